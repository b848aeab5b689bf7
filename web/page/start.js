// Starts the page's script, which script element cvol-app has, by gzip in base64. (unpack.js is a part of it.)

async function start() {
  const letters = atob(document.getElementById("cvol-app").textContent);
  const zipped = new Blob([Uint8Array.from(letters, (letter) => letter.charCodeAt(0))]);
  const script = document.createElement("script");
  script.type = "module";
  script.textContent = await new Response(zipped.stream().pipeThrough(new DecompressionStream("gzip"))).text();
  document.body.append(script);
}

function refuse() {
  const notice = document.getElementById("notice");
  notice.append("This page needs a newer browser: Chrome 91, Firefox 113, Safari 16.4 or later.");
  notice.hidden = false;
}

// Chrome has it since 2020, Firefox and Safari since 2023.
if (globalThis.DecompressionStream) start();
else refuse();
