// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/module_file.hpp"

#include <link.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "tandem/runtime/module_mark.hpp"

namespace tandem::runtime {
namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);
using Note = ElfW(Nhdr);

constexpr unsigned char kClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;

template <class T>
bool read_at(std::ifstream& in, std::uint64_t offset, T& value) {
  in.seekg(static_cast<std::streamoff>(offset));
  in.read(reinterpret_cast<char*>(&value), sizeof value);
  return in.good();
}

std::uint64_t padded(std::uint64_t size, std::uint64_t alignment) {
  return (size + alignment - 1) / alignment * alignment;
}

template <std::size_t size>
std::string text(const char (&field)[size]) {
  return {field, std::find(field, field + size, '\0')};
}

bool is_mark(const ModuleMark& mark) {
  const ModuleMark ours;
  return mark.owner_size == ours.owner_size && mark.type == ours.type &&
         std::memcmp(mark.owner, ours.owner, sizeof ours.owner) == 0;
}

// The mark among the notes of a segment. The file may be damaged: sizes are not trusted.
std::optional<ModuleInfo> find_in(std::ifstream& in, const Segment& segment) {
  const std::uint64_t alignment = segment.p_align == 8 ? 8 : 4;
  std::uint64_t at = segment.p_offset;
  const std::uint64_t end = at + segment.p_filesz;
  Note note{};
  while (at + sizeof note <= end && read_at(in, at, note)) {
    ModuleMark mark;
    if (read_at(in, at, mark) && is_mark(mark))
      return ModuleInfo{text(mark.abi), text(mark.component), text(mark.package)};
    in.clear();
    at += sizeof note + padded(note.n_namesz, alignment) + padded(note.n_descsz, alignment);
  }
  return std::nullopt;
}

}  // namespace

std::optional<ModuleInfo> read_module(const std::filesystem::path& file) {
  std::ifstream in{file, std::ios::binary};
  Header header{};
  if (!read_at(in, 0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 ||
      header.e_ident[EI_CLASS] != kClass || header.e_phentsize != sizeof(Segment))
    return std::nullopt;
  for (int i = 0; i < header.e_phnum; ++i) {
    Segment segment{};
    if (!read_at(in, header.e_phoff + static_cast<std::uint64_t>(i) * sizeof segment, segment))
      return std::nullopt;
    if (segment.p_type != PT_NOTE) continue;
    if (auto found = find_in(in, segment)) return found;
  }
  return std::nullopt;
}

}  // namespace tandem::runtime
