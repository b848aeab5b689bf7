// Drives Firefox by its own remote protocol, Marionette: messages are [0, id, command, parameters] and
// [1, id, error, result] as JSON, each after its length in bytes and a colon.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createConnection } from "node:net";
import { tmpdir } from "node:os";
import path from "node:path";

const TIMEOUT_MS = 60000;
const PAUSE_MS = 100;
const PREFERENCES = {
  "marionette.port": 0, // any; the profile then says which
  "webgl.disabled": true,
  "datareporting.policy.dataSubmissionEnabled": false,
  "app.update.enabled": false,
  "browser.shell.checkDefaultBrowser": false,
};
const pause = () => new Promise((done) => setTimeout(done, PAUSE_MS));

async function waitFor(what, fn) {
  for (const end = Date.now() + TIMEOUT_MS; Date.now() < end; await pause()) {
    const value = await fn();
    if (value) return value;
  }
  throw new Error(`Firefox: ${what} does not come`);
}

function connect(port) {
  const socket = createConnection(port, "127.0.0.1");
  const waiting = new Map();
  let received = Buffer.alloc(0);
  let id = 0;
  socket.on("data", (part) => {
    received = Buffer.concat([received, part]);
    for (let colon; (colon = received.indexOf(":")) > 0; ) {
      const length = Number(received.subarray(0, colon));
      if (received.length < colon + 1 + length) return;
      const message = JSON.parse(received.subarray(colon + 1, colon + 1 + length));
      received = received.subarray(colon + 1 + length);
      if (!Array.isArray(message)) continue; // the greeting
      const [, of, error, result] = message;
      const { resolve, reject } = waiting.get(of);
      if (error) reject(new Error(`Firefox: ${error.message}`));
      else resolve(result);
    }
  });
  return {
    send: (command, parameters = {}) =>
      new Promise((resolve, reject) => {
        waiting.set(++id, { resolve, reject });
        const text = JSON.stringify([0, id, command, parameters]);
        socket.write(`${Buffer.byteLength(text)}:${text}`);
      }),
    end: () => socket.destroy(),
  };
}

/** Starts Firefox without a window. {open(address), run(code): its value, until(code): the first true value, shot(file), end()} */
export async function startFirefox(program, width, height) {
  const profile = mkdtempSync(path.join(tmpdir(), "cvol-firefox-"));
  const lines = Object.entries(PREFERENCES).map(([name, value]) => `user_pref("${name}", ${JSON.stringify(value)});\n`);
  writeFileSync(path.join(profile, "user.js"), lines.join(""));
  const options = ["--headless", "--marionette", "--no-remote", "--profile", profile];
  const child = spawn(program, options, { stdio: "ignore", env: { ...process.env, HOME: profile, MOZ_WEBRENDER: "0" } });
  const ended = new Promise((done) => child.on("exit", done));
  process.on("exit", () => child.kill());
  const portFile = path.join(profile, "MarionetteActivePort");
  const port = await waitFor("its port", () => existsSync(portFile) && Number(readFileSync(portFile, "utf8")));
  const { send, end } = connect(port);
  await send("WebDriver:NewSession", { capabilities: {} });
  await send("WebDriver:SetWindowRect", { width, height });
  const run = async (code) => (await send("WebDriver:ExecuteScript", { script: `return (${code});`, args: [], sandbox: null })).value;
  return {
    open: (url) => send("WebDriver:Navigate", { url }),
    run,
    until: (code) => waitFor(code, () => run(code)),
    async shot(file) {
      const { value } = await send("WebDriver:TakeScreenshot", { full: false });
      writeFileSync(file, Buffer.from(value, "base64"));
    },
    async end() {
      await send("Marionette:Quit", { flags: ["eForceQuit"] }).catch(() => {});
      end();
      await ended;
      rmSync(profile, { recursive: true, force: true });
    },
  };
}
