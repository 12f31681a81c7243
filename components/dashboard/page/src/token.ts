// SPDX-License-Identifier: Apache-2.0
// The secret that the robot's address carries: out of the address bar once it is known.

const KEY = "tandem.token";

/// The token of the address or, after that was cleaned, of this tab: it survives a reload, the way
/// back and a phone that wakes up, and ends with the tab. Empty: none is known.
export function takeToken(): string {
  const url = new URL(location.href);
  const given = url.searchParams.get("token");
  if (given === null) return sessionStorage.getItem(KEY) ?? "";
  sessionStorage.setItem(KEY, given);
  url.searchParams.delete("token");
  history.replaceState(history.state, "", url);
  return given;
}
