// Starts the page's script, which script element cvol-app has, by gzip in base64. (unpack.js is a part of it.)

const letters = atob(document.getElementById("cvol-app").textContent);
const zipped = new Blob([Uint8Array.from(letters, (letter) => letter.charCodeAt(0))]);
const script = document.createElement("script");
script.type = "module";
script.textContent = await new Response(zipped.stream().pipeThrough(new DecompressionStream("gzip"))).text();
document.body.append(script);
