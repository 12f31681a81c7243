// SPDX-License-Identifier: Apache-2.0
#include "tandem/dashboard/web/page_files.hpp"

// The assembler embeds each file into the library, between two symbols.
#define TANDEM_EMBED(name, file)                                                 \
  asm(".section .rodata\n"                                                       \
      ".hidden tandem_" #name "\n.global tandem_" #name                          \
      "\n"                                                                       \
      ".hidden tandem_" #name "_end\n.global tandem_" #name                      \
      "_end\n"                                                                   \
      "tandem_" #name ":\n.incbin \"" TANDEM_PAGE_DIR "/" file                   \
      "\"\n"                                                                     \
      "tandem_" #name "_end:\n.byte 0\n.previous\n");                            \
  extern "C" {                                                                   \
  __attribute__((visibility("hidden"))) extern const char tandem_##name[];       \
  __attribute__((visibility("hidden"))) extern const char tandem_##name##_end[]; \
  }

TANDEM_EMBED(index_html, "index.html")
TANDEM_EMBED(app_js, "app.js")
TANDEM_EMBED(app_css, "app.css")

namespace tandem {
namespace {

WebFile file(std::string_view type, const char* begin, const char* end) {
  return {type, {begin, static_cast<std::size_t>(end - begin)}};
}

}  // namespace

std::map<std::string, WebFile> page_files() {
  const auto index = file("text/html; charset=utf-8", tandem_index_html, tandem_index_html_end);
  return {{"/", index},
          {"/index.html", index},
          {"/app.js", file("text/javascript; charset=utf-8", tandem_app_js, tandem_app_js_end)},
          {"/app.css", file("text/css; charset=utf-8", tandem_app_css, tandem_app_css_end)}};
}

}  // namespace tandem
