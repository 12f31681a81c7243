// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "tandem/dashboard/web/web_server.hpp"

namespace tandem {

/// The built page (page/dist/), embedded into the library, by path.
[[nodiscard]] std::map<std::string, WebFile> page_files();

}  // namespace tandem
