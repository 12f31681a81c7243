// SPDX-License-Identifier: Apache-2.0
#include "tandem/local_planner/solvers/ipopt_options.hpp"

namespace tandem {

using Ipopt::Index;
using Ipopt::Number;
using Ipopt::OptionsList;

template <class Ask>
const RememberedOptions::Answer& RememberedOptions::remembered(Kind kind, const std::string& tag,
                                                               const std::string& prefix,
                                                               Ask&& ask) const {
  std::vector<Answer>& answers = answers_[tag];
  for (const Answer& answer : answers)
    if (answer.kind == kind && answer.prefix == prefix) return answer;
  Answer answer{kind, prefix, false, 0.0, {}};
  ask(answer);
  return answers.emplace_back(std::move(answer));
}

bool RememberedOptions::SetStringValue(const std::string& tag, const std::string& value,
                                       bool allow_clobber, bool dont_print) {
  answers_.erase(tag);
  return OptionsList::SetStringValue(tag, value, allow_clobber, dont_print);
}

bool RememberedOptions::SetNumericValue(const std::string& tag, Number value, bool allow_clobber,
                                        bool dont_print) {
  answers_.erase(tag);
  return OptionsList::SetNumericValue(tag, value, allow_clobber, dont_print);
}

bool RememberedOptions::SetIntegerValue(const std::string& tag, Index value, bool allow_clobber,
                                        bool dont_print) {
  answers_.erase(tag);
  return OptionsList::SetIntegerValue(tag, value, allow_clobber, dont_print);
}

bool RememberedOptions::GetStringValue(const std::string& tag, std::string& value,
                                       const std::string& prefix) const {
  const Answer& answer = remembered(Kind::kString, tag, prefix, [&](Answer& ask) {
    ask.is_set = OptionsList::GetStringValue(tag, ask.text, prefix);
  });
  value = answer.text;
  return answer.is_set;
}

bool RememberedOptions::GetEnumValue(const std::string& tag, Index& value,
                                     const std::string& prefix) const {
  const Answer& answer = remembered(Kind::kEnum, tag, prefix, [&](Answer& ask) {
    Index index = 0;
    ask.is_set = OptionsList::GetEnumValue(tag, index, prefix);
    ask.number = index;
  });
  value = static_cast<Index>(answer.number);
  return answer.is_set;
}

bool RememberedOptions::GetBoolValue(const std::string& tag, bool& value,
                                     const std::string& prefix) const {
  const Answer& answer = remembered(Kind::kBool, tag, prefix, [&](Answer& ask) {
    bool is_true = false;
    ask.is_set = OptionsList::GetBoolValue(tag, is_true, prefix);
    ask.number = is_true ? 1.0 : 0.0;
  });
  value = answer.number != 0.0;
  return answer.is_set;
}

bool RememberedOptions::GetNumericValue(const std::string& tag, Number& value,
                                        const std::string& prefix) const {
  const Answer& answer = remembered(Kind::kNumber, tag, prefix, [&](Answer& ask) {
    ask.is_set = OptionsList::GetNumericValue(tag, ask.number, prefix);
  });
  value = answer.number;
  return answer.is_set;
}

bool RememberedOptions::GetIntegerValue(const std::string& tag, Index& value,
                                        const std::string& prefix) const {
  const Answer& answer = remembered(Kind::kInteger, tag, prefix, [&](Answer& ask) {
    Index index = 0;
    ask.is_set = OptionsList::GetIntegerValue(tag, index, prefix);
    ask.number = index;
  });
  value = static_cast<Index>(answer.number);
  return answer.is_set;
}

}  // namespace tandem
