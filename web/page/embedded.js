// The volumes of a page of cvol export --html: script elements have them.

import { bytesOf } from "./unpack.js";

const element = (id) => document.getElementById(id);
const about = JSON.parse(element("cvol-about").textContent);

export const START = about.start;
export const TITLE = about.title;

// {files: [{name, bytes}], volumes: [{file (its name), name, time, channel}]}
export const firstVolumes = async () => ({
  files: about.files.map((name, i) => ({ name, bytes: bytesOf(element(`cvol-file-${i}`).textContent).buffer })),
  volumes: about.volumes,
});

// Calls fn(the same for all volumes, new ones too): never in this page.
export const onVolumes = () => {};
