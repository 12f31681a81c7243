// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/extension.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "tandem/runtime/detail/module_folders.hpp"
#include "tandem/version.hpp"

namespace tandem::runtime {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy = ": install Tandem again, and restart what runs";

fs::path find_extension(const std::string& name) {
  const std::string file = "libtandem-" + name + ".so";
  std::string searched;
  for (const auto& folder : own_module_folders()) {
    std::error_code ignored;
    if (fs::exists(folder / file, ignored)) return folder / file;
    searched += (searched.empty() ? "" : ", ") + folder.string();
  }
  throw std::runtime_error(file + " is in none of " + searched + kRemedy);
}

void* symbol_of(void* module, const char* symbol) {
  void* found = module == nullptr ? nullptr : dlsym(module, symbol);
  if (found == nullptr) throw std::runtime_error(dlerror() + std::string{kRemedy});
  return found;
}

}  // namespace

void* function_of_extension(const std::string& name, const char* symbol) {
  const fs::path file = find_extension(name);
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  const std::string version = static_cast<const char*>(symbol_of(module, "tandem_version"));
  if (version != TANDEM_VERSION)
    throw std::runtime_error(file.string() + " is of Tandem " + version +
                             ", this is Tandem " TANDEM_VERSION + kRemedy);
  return symbol_of(module, symbol);
}

}  // namespace tandem::runtime
