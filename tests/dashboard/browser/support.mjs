// SPDX-License-Identifier: Apache-2.0
// What the programs here share: a system as a process, and a hand on the page's stick.
import { spawn } from "node:child_process";

/** Starts `tandem run FILE --ros-args ...`; gives back the process and, once it is known, the port of its page. */
export function startSystem(tandem, file, rosArguments) {
  const all = ["run", file, "--ros-args", "-p", "dashboard:port:=0", ...rosArguments];
  const robot = spawn("setpriv", ["--pdeathsig", "KILL", tandem, ...all], { stdio: ["ignore", "inherit", "pipe"] });
  const port = new Promise((resolve, reject) => {
    let log = "";
    robot.stderr.on("data", (text) => {
      process.stderr.write(text);
      log += text;
      const found = log.match(/the page is at http:\/\/127\.0\.0\.1:(\d+)\//);
      if (found) resolve(Number(found[1]));
    });
    robot.on("exit", () => reject(new Error(`${file} did not start`)));
  });
  return { robot, port };
}

/** Moves the mouse on the stick of the screen: `forward` and `left` in [-1, 1]. */
export async function stick(page, forward, left) {
  const box = await page.locator("#stick").boundingBox();
  const reach = 0.3 * box.width;
  await page.mouse.move(box.x + box.width / 2 - left * reach, box.y + box.height / 2 - forward * reach);
}
