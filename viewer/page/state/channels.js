// The channels of a file in a view: state.view.channels is a list of {volume, on, colour, transfer, opacity_scale,
// window}, or null. One channel is chosen: state.view.volume, whose settings are those of the view itself.

import { directions, sum } from "./camera.js";

const COMPONENT = "component";

const isColour = (value) => Array.isArray(value) && value.length === 3 && value.every((c) => c >= 0 && c <= 1);

// 1 if a value from a link can be a list of channels.
export function areChannels(value) {
  const fits = (channel) => typeof channel?.volume === "string" && isColour(channel.colour);
  return value === null || (Array.isArray(value) && value.length > 0 && value.every(fits));
}

// The name of a channel.
export const channelName = ({ channel }) => channel.name ?? `Channel ${channel.number}`;

// The channels of the file of a volume as it is first shown; null: it has one. `all`: all volumes.
export function channelsOf(volume, all) {
  if (!volume?.channel || volume.parent !== null) return null;
  const of = all.filter((other) => other.parent === null && other.channel?.first === volume.channel.first);
  return of.map(({ id, channel: { colour, component } }) => ({
    volume: id,
    on: true,
    colour,
    transfer: component ? COMPONENT : "microscopy",
    opacity_scale: 1,
    window: null,
  }));
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// The default view of several: what is visible in any of them.
function joinedHome(homes) {
  const { right, up, eye } = directions(homes[0], false);
  const spanOf = (axis, size) => {
    const low = homes.map((home) => dot(home.look_at, axis) - size(home) / 2);
    const high = homes.map((home) => dot(home.look_at, axis) + size(home) / 2);
    return [Math.min(...low), Math.max(...high)];
  };
  const [left, wide] = spanOf(right, ({ size }) => size[0]);
  const [bottom, top] = spanOf(up, ({ size }) => size[1]);
  const [near, far] = spanOf(eye, () => 0);
  const look_at = sum([(left + wide) / 2, right], [(bottom + top) / 2, up], [(near + far) / 2, eye]);
  return { ...homes[0], look_at, size: [wide - left, top - bottom] };
}

// The volumes of the program; channels that are ready share a default view.
export function withJoinedHomes(all) {
  const groups = new Map();
  for (const { channel, parent, home } of all)
    if (channel && parent === null && home?.size)
      groups.set(channel.first, [...(groups.get(channel.first) ?? []), home]);
  return all.map((volume) => {
    const homes = volume.home && volume.parent === null ? groups.get(volume.channel?.first) : null;
    return homes ? { ...volume, home: joinedHome(homes) } : volume;
  });
}

// The colour of a channel on its transfer function, whose brightness stays.
export function tinted(points, { channels, volume }) {
  const colour = channels?.find((channel) => channel.volume === volume)?.colour;
  const most = colour && Math.max(...colour);
  if (!most) return points;
  return points.map(([value, r, g, b, opacity]) => {
    const light = Math.max(r, g, b) / most;
    return [value, ...colour.map((part) => light * part), opacity];
  });
}

// The channels of a link if they are those of the volume; null: they are not.
export function sameChannels(linked, own) {
  const ids = (list) => list?.map(({ volume }) => volume).join();
  return own && ids(linked) === ids(own) ? linked.map((channel, i) => ({ ...own[i], ...channel })) : null;
}

// The channels of a view with the settings of the chosen one.
function current({ volume, channels, transfer, opacity_scale, window }) {
  return channels.map((channel) =>
    channel.volume === volume ? { ...channel, transfer, opacity_scale, window } : channel,
  );
}

// The part of a view that chooses another channel.
export function chosenChannel(view, volume) {
  const channels = current(view);
  const { transfer, opacity_scale, window } = channels.find((channel) => channel.volume === volume);
  return { volume, channels, transfer, opacity_scale, window };
}

// The channels of a request; null: the volume alone.
export function requestChannels(view) {
  if (!view.channels || !["composite", "mip", "xray"].includes(view.mode)) return null;
  return current(view)
    .filter(({ on }) => on)
    .map(({ on, ...channel }) => {
      if (channel.window === null) delete channel.window;
      return channel;
    });
}
