// SPDX-License-Identifier: Apache-2.0
#include "bringup/command_line/command_line.hpp"

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <system_error>

#include "tandem/runtime/dds_security.hpp"
#include "tandem/version.hpp"

namespace tandem {
namespace {

// The word in the position of a required command; empty if there is none.
std::string unknown_command(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  const auto words = at->remaining();
  return at->get_require_subcommand_min() == 0 || words.empty() ? "" : words.front();
}

// The system's message about the limit of threads and processes does not name the remedy.
std::string explained(const std::exception& error) {
  const std::string what = error.what();
  const auto no_more = std::make_error_code(std::errc::resource_unavailable_try_again).message();
  return what.find(no_more) == std::string::npos
             ? what
             : what + ": no more threads or processes for this user; raise `ulimit -u`";
}

}  // namespace

int run_command_line(int argc, char** argv,
                     const std::function<void(CLI::App&, int& status)>& add) {
  CLI::App app{"Tandem: shared control for differential-drive robots"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "tandem " TANDEM_VERSION);
  int status = 0;
  add(app, status);
  try {
    for (int i = 1; i < argc; ++i)  // CLI11 would treat an empty argument as not given
      if (*argv[i] == '\0')
        throw std::invalid_argument("argument " + std::to_string(i) +
                                    " is empty; is a variable of the shell unset?");
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error(
          "cannot write to standard output (is the disk full, or was the pipe closed?)");
    return status;
  } catch (const CLI::RequiredError& error) {
    const std::string unknown = unknown_command(app);
    if (unknown.empty()) return app.exit(error), 1;
    std::fprintf(stderr, "tandem: no command '%s'; --help lists them\n", unknown.c_str());
    return 1;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;  // exit() returns 0 for --help
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", explained(error).c_str());
    return 1;
  }
}

void add_enclave_option(CLI::App& command) {
  command.add_option_function<std::string>("--enclave", runtime::set_enclave,
                                           "enclave in ROS_SECURITY_KEYSTORE, with "
                                           "ROS_SECURITY_ENABLE=true");
}

}  // namespace tandem
