// SPDX-License-Identifier: Apache-2.0
// An Ipopt options list that caches lookups, because they dominate the time of short solves.
#pragma once

#include <IpOptionsList.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace tandem {

/// Ipopt reads about three hundred options per solve and searches two string trees for each, which
/// takes longer than a short solve. This list caches every answer until the option is set again.
class RememberedOptions : public Ipopt::OptionsList {
 public:
  bool SetStringValue(const std::string& tag, const std::string& value, bool allow_clobber = true,
                      bool dont_print = false) override;
  bool SetNumericValue(const std::string& tag, Ipopt::Number value, bool allow_clobber = true,
                       bool dont_print = false) override;
  bool SetIntegerValue(const std::string& tag, Ipopt::Index value, bool allow_clobber = true,
                       bool dont_print = false) override;

  bool GetStringValue(const std::string& tag, std::string& value,
                      const std::string& prefix) const override;
  bool GetEnumValue(const std::string& tag, Ipopt::Index& value,
                    const std::string& prefix) const override;
  bool GetBoolValue(const std::string& tag, bool& value, const std::string& prefix) const override;
  bool GetNumericValue(const std::string& tag, Ipopt::Number& value,
                       const std::string& prefix) const override;
  bool GetIntegerValue(const std::string& tag, Ipopt::Index& value,
                       const std::string& prefix) const override;

 private:
  enum class Kind { kString, kEnum, kBool, kNumber, kInteger };
  struct Answer {
    Kind kind;
    std::string prefix;
    bool is_set;  // false: the value is the default
    double number;
    std::string text;
  };
  template <class Ask>
  const Answer& remembered(Kind kind, const std::string& tag, const std::string& prefix,
                           Ask&& ask) const;

  mutable std::unordered_map<std::string, std::vector<Answer>> answers_;
};

}  // namespace tandem
