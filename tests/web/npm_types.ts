// Uses of the package's types: tsc --strict accepts these, and refuses each line after @ts-expect-error.
import { CvolFile, decode, openRange, render, Renderer, type Picture, type Volume } from "cvol";
import { CvolCodec } from "cvol/zarrita";

async function use(bytes: Uint8Array, canvas: HTMLCanvasElement): Promise<number> {
  const volume: Volume = await decode(bytes, { level: 1, box: [0, 0, 0, 4, 4, 4] });
  const loaded: CvolFile = await openRange("https://example.org/a.cvol", { level: 2, onProgress: (n, of) => void (n / of) });
  const picture: Picture = await render(canvas, loaded, { mode: "mip", camera: { azimuth: 30 } });
  const renderer = await Renderer.create(bytes, { time: 2 });
  renderer.draw({ transfer: [[0, 1, 1, 1, 0]] });
  // @ts-expect-error: no such mode
  renderer.draw({ mode: "solid" });
  // @ts-expect-error: a number
  await decode(bytes, { level: "coarse" });
  const chunk = await new CvolCodec({}, { shape: [2, 3, 4] }).decode(bytes);
  return volume.data.length + picture.data.length + chunk.stride[0];
}
export default use;
