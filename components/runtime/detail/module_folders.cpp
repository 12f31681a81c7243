// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/module_folders.hpp"

#include <dlfcn.h>

#include <system_error>

namespace tandem::runtime {
namespace fs = std::filesystem;

fs::path runtime_file() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&runtime_file), &info) == 0) return {};
  std::error_code ignored;
  return fs::weakly_canonical(info.dli_fname, ignored);
}

std::vector<fs::path> own_module_folders() {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  const fs::path runtime = runtime_file().parent_path();
  std::vector<fs::path> folders{program};
  if (runtime.empty()) return folders;
  if (runtime != program) folders.push_back(runtime);
  folders.push_back(runtime / "tandem");
  return folders;
}

}  // namespace tandem::runtime
