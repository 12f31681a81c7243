// SPDX-License-Identifier: Apache-2.0
#include "bringup/study/study_report.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "bringup/study/shell_quoted.hpp"
#include "bringup/system/shared_files.hpp"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// The first interpreter with matplotlib. Debian's package installs it for /usr/bin/python3, which
// need not be the first python3 in PATH.
std::optional<std::string> python() {
  for (const std::string program : {"python3", "/usr/bin/python3"})
    if (std::system((program + " -c 'import matplotlib' >/dev/null 2>&1").c_str()) == 0)
      return program;
  return std::nullopt;
}

}  // namespace

void draw_report(const std::string& folder) {
  const fs::path script = share_folder() / "report" / "report.py";
  const auto interpreter = python();
  if (!interpreter || !fs::exists(script)) {
    std::fprintf(stderr, "no report: %s\n",
                 interpreter ? (script.string() + " is missing").c_str()
                             : "matplotlib is missing; run apt-get install python3-matplotlib, "
                               "then this command again");
    return;
  }
  const std::string command =
      *interpreter + " " + shell_quoted(script.string()) + " " + shell_quoted(folder);
  if (std::system(command.c_str()) != 0)
    throw std::runtime_error("the report failed; the results are in " + folder);
}

}  // namespace tandem
