// SPDX-License-Identifier: Apache-2.0
#include "tandem/runtime/detail/cdr_structure.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>

#include "tandem/runtime/detail/rtps_message.hpp"
#include "type_hashes.hpp"

namespace tandem::runtime {
namespace {

using CdrField = CdrStructure::Field;

constexpr std::size_t kEncapsulation = 4;

// Type ids as in type_description_interfaces/msg/FieldType.
constexpr int kNested = 1, kText = 17, kBoundedText = 21;
// Ids per shape: single value, array, bounded sequence, unbounded sequence.
constexpr int kPerShape = 48;

std::size_t primitive_size(int id) {
  constexpr std::size_t kSizes[] = {0, 0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 16, 1, 2, 1, 1};
  return id < static_cast<int>(std::size(kSizes)) ? kSizes[id] : 0;
}

CdrField::Of element_of(int id) {
  if (id == kNested) return CdrField::Of::kStructures;
  return id == kText || id == kBoundedText ? CdrField::Of::kTexts : CdrField::Of::kPrimitives;
}

CdrField::Many shape_of(int type_id) {
  const int shape = (type_id - 1) / kPerShape;
  if (shape == 0) return CdrField::Many::kOne;
  return shape == 1 ? CdrField::Many::kArray : CdrField::Many::kSequence;
}

CdrField field_of(const DescribedField& described) {
  const int id = (described.type_id - 1) % kPerShape + 1;
  const CdrField::Of of = element_of(id);
  const auto many = shape_of(described.type_id);
  return {of, many, primitive_size(id), many == CdrField::Many::kArray ? described.capacity : 1,
          of == CdrField::Of::kStructures ? CdrStructure::of(described.nested) : nullptr};
}

}  // namespace

// Steps through the serialized fields of one message, and copies them to the end of another if it
// is given one.
class CdrWalk {
 public:
  explicit CdrWalk(std::span<const std::uint8_t> message, std::vector<std::uint8_t>* copy = nullptr)
      : bytes_{message.subspan(kEncapsulation)}, little_{message[1] == 1}, copy_{copy} {}

  bool skip(const CdrStructure& structure) {
    for (const CdrField& field : structure.fields_)
      if (!skip(field)) return false;
    return true;
  }

 private:
  bool skip(const CdrField& field) {
    std::size_t count = field.count;
    if (field.many == CdrField::Many::kSequence && !read_count(count)) return false;
    return skip_elements(field, count);
  }

  bool skip_elements(const CdrField& field, std::size_t count) {
    if (count > left() / CdrStructure::least(field)) return false;
    if (field.of == CdrField::Of::kPrimitives) return skip_primitives(field.size, count);
    for (std::size_t i = 0; i < count; ++i)
      if (field.structure != nullptr ? !skip(*field.structure) : !skip_text()) return false;
    return true;
  }

  // An empty sequence is followed by no alignment padding.
  bool skip_primitives(std::size_t size, std::size_t count) {
    if (count == 0) return true;
    align(size > 8 ? 8 : size);
    if (count > left() / size) return false;
    copy(size, count);
    at_ += size * count;
    return true;
  }

  bool skip_text() {
    std::size_t size = 0;
    if (!read_count(size) || size > left()) return false;
    copy(1, size);
    at_ += size;
    return true;
  }

  bool read_count(std::size_t& count) {
    align(4);
    if (left() < 4) return false;
    count = rtps_message::u32(bytes_.data() + at_, little_);
    copy(4, 1);
    at_ += 4;
    return true;
  }

  // Copies the elements that follow, of the given size each.
  void copy(std::size_t size, std::size_t count) {
    if (copy_ == nullptr || count == 0) return;
    const std::size_t alignment = std::min<std::size_t>(size, 8);
    while ((copy_->size() - kEncapsulation) % alignment != 0) copy_->push_back(0);
    for (std::size_t i = 0; i < count; ++i) {
      const auto element = bytes_.subspan(at_ + i * size, size);
      if (little_)
        copy_->insert(copy_->end(), element.begin(), element.end());
      else
        copy_->insert(copy_->end(), element.rbegin(), element.rend());
    }
  }

  void align(std::size_t size) { at_ = (at_ + size - 1) & ~(size - 1); }
  [[nodiscard]] std::size_t left() const { return at_ < bytes_.size() ? bytes_.size() - at_ : 0; }

  std::span<const std::uint8_t> bytes_;
  bool little_;
  std::vector<std::uint8_t>* copy_;
  std::size_t at_ = 0;
};

CdrStructure::CdrStructure(std::string_view type) {
  for (const DescribedField& described : described_type(type)->fields) {
    const CdrField& field = fields_.emplace_back(field_of(described));
    const bool sequence = field.many == CdrField::Many::kSequence;
    least_ += sequence ? 4 : least(field) * field.count;
    bounded_ = bounded_ && !sequence && field.of != CdrField::Of::kTexts &&
               (field.structure == nullptr || field.structure->bounded_);
    most_ += field.count * (field.structure != nullptr ? field.structure->most_ : 2 * field.size);
  }
}

std::size_t CdrStructure::least(const Field& field) {
  if (field.structure != nullptr) return field.structure->least_;
  return field.of == CdrField::Of::kTexts ? 4 : field.size;
}

std::optional<std::size_t> CdrStructure::largest() const {
  if (!bounded_) return std::nullopt;
  return kEncapsulation + most_;
}

const CdrStructure* CdrStructure::of(std::string_view type) {
  static std::recursive_mutex mutex;  // the constructor looks up nested structures
  static std::map<std::string, std::unique_ptr<CdrStructure>, std::less<>> all;
  const std::lock_guard lock{mutex};
  if (const auto known = all.find(type); known != all.end()) return known->second.get();
  if (described_type(type) == nullptr) return nullptr;
  std::unique_ptr<CdrStructure> made{new CdrStructure{type}};
  return all.emplace(type, std::move(made)).first->second.get();
}

bool CdrStructure::fits(std::span<const std::uint8_t> bytes) const {
  return bytes.size() >= kEncapsulation && CdrWalk{bytes}.skip(*this);
}

bool CdrStructure::append(std::span<const std::uint8_t> message,
                          std::vector<std::uint8_t>& out) const {
  return message.size() >= kEncapsulation && CdrWalk{message, &out}.skip(*this);
}

}  // namespace tandem::runtime
