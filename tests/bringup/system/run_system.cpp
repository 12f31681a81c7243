// SPDX-License-Identifier: Apache-2.0
// `tandem run` alone, for the tests of bringup/system: run_system run FILE [--separate] [--only
// NAME]…
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "bringup/system/system.hpp"

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 2, argv + argc);
  std::vector<std::string> only, ros_args;
  bool separate = false;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "--separate")
      separate = true;
    else if (words[i] == "--only")
      only.push_back(words.at(++i));
    else
      ros_args.push_back(words[i]);
  }
  return tandem::run_system(words.at(0), only, separate, ros_args);
} catch (const std::exception& error) {
  std::fprintf(stderr, "run_system: %s\n", error.what());
  return 1;
}
