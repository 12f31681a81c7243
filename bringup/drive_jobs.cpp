// SPDX-License-Identifier: Apache-2.0
#include "bringup/drive_jobs.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace tandem {
namespace {

constexpr unsigned kMostSeeds = 100000;

using DriveFunction = std::function<DriveResult(const DriveJob&)>;

// Worker w takes every workers-th drive and leaves its results, a line of JSON each, in its file.
[[noreturn]] void work(const std::vector<DriveJob>& jobs, unsigned workers,
                       const DriveFunction& drive, unsigned w, std::FILE* out) {
  try {
    for (std::size_t i = w; i < jobs.size(); i += workers) {
      const nlohmann::json result = drive(jobs[i]);
      std::fprintf(out, "%zu %s\n", i, result.dump().c_str());
    }
    std::fflush(nullptr);
    std::_Exit(0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    std::_Exit(1);
  }
}

void collect(std::FILE* file, std::vector<DriveResult>& results) {
  std::rewind(file);
  std::string line;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
    if (c != '\n') {
      line.push_back(static_cast<char>(c));
      continue;
    }
    const auto space = line.find(' ');
    results.at(std::stoul(line.substr(0, space))) = nlohmann::json::parse(line.substr(space + 1));
    line.clear();
  }
  std::fclose(file);
}

}  // namespace

SeedRange seed_range(const std::string& option, const std::string& text) {
  unsigned first = 0, last = 0;
  char rest = '\0';
  if (std::sscanf(text.c_str(), "%u-%u%c", &first, &last, &rest) != 2 || first == 0 ||
      last < first || last - first >= kMostSeeds)
    throw std::invalid_argument(option + " " + text + ": expected A-B with 1 <= A <= B, " +
                                std::to_string(kMostSeeds) + " at most");
  return {first, last};
}

std::vector<DriveResult> run_side_by_side(const std::vector<DriveJob>& jobs, unsigned workers,
                                          const DriveFunction& drive) {
  std::vector<std::pair<pid_t, std::FILE*>> running;
  std::fflush(nullptr);
  for (unsigned w = 0; w < workers; ++w) {
    std::FILE* file = std::tmpfile();
    if (file == nullptr) throw std::runtime_error("cannot make a temporary file");
    const pid_t child = fork();
    if (child == 0) work(jobs, workers, drive, w, file);
    if (child < 0) throw std::runtime_error("cannot start a worker process");
    running.emplace_back(child, file);
  }
  bool failed = false;
  std::vector<DriveResult> results(jobs.size());
  for (const auto& [child, file] : running) {
    int status = 0;
    waitpid(child, &status, 0);
    failed = failed || !WIFEXITED(status) || WEXITSTATUS(status) != 0;
    collect(file, results);
  }
  if (failed) throw std::runtime_error("a worker did not finish its drives");
  return results;
}

}  // namespace tandem
