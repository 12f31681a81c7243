// SPDX-License-Identifier: Apache-2.0
// Build step `hash_types OUT IDL... [--known IDL...]`: writes C++ code that adds the type
// descriptions and type hashes of the first files to those of type_hashes.hpp. The files after
// --known define types that the first ones may use.
//
// Parses the subset of IDL that ROS 2's generator writes (modules, structures, constants, default
// values), describes each structure in the form of type_description_interfaces, and hashes the
// description according to REP-2016 (RIHS01): SHA-256 of its JSON without default values, with
// nested types sorted by name.
#include <openssl/sha.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

// type_description_interfaces/msg/FieldType
const std::map<std::string, int> kBasicTypes{
    {"int8", 2},     {"uint8", 3},  {"int16", 4},   {"uint16", 5},  {"int32", 6}, {"uint32", 7},
    {"int64", 8},    {"uint64", 9}, {"float", 10},  {"double", 11}, {"char", 13}, {"wchar", 14},
    {"boolean", 15}, {"octet", 16}, {"string", 17}, {"wstring", 18}};
constexpr int kNested = 1, kBoundedString = 4;  // kBoundedString: added to the id
constexpr int kArray = 48, kBoundedSequence = 96, kUnboundedSequence = 144;

struct Field {
  std::string name;
  int type_id = 0;
  long capacity = 0, string_capacity = 0;
  std::string nested{};         // package/kind/Name
  std::string default_value{};  // as in the IDL; empty: none
};

using Structures = std::map<std::string, std::vector<Field>>;

struct Constant {
  std::string name;
  int type_id = 0;
  std::string value;  // as in the IDL
};

using Constants = std::map<std::string, std::vector<Constant>>;  // by structure

constexpr std::string_view kConstants = "_Constants";  // ends the name of a structure's module

// The index behind the string that begins at `at`.
std::size_t end_of_string(const std::string& line, std::size_t at) {
  while (++at < line.size() && line[at] != '"')
    if (line[at] == '\\') ++at;
  return std::min(at + 1, line.size());
}

std::vector<std::string> tokens_of(const std::string& path) {
  std::ifstream in{path};
  if (!in) throw std::runtime_error(path + ": cannot be read");
  std::vector<std::string> tokens;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    for (std::size_t i = 0; i < line.size() && line.compare(i, 2, "//") != 0;) {
      const auto is_word = [&](std::size_t at) {
        return std::isalnum(static_cast<unsigned char>(line[at])) != 0 || line[at] == '_';
      };
      std::size_t end = i;
      while (end < line.size() && is_word(end)) ++end;
      if (line[i] == '"') end = end_of_string(line, i);
      if (end == i) end = line.compare(i, 2, "::") == 0 ? i + 2 : i + 1;
      if (line[i] != ' ' && line[i] != '\t') tokens.push_back(line.substr(i, end - i));
      i = end;
    }
  }
  return tokens;
}

class Parser {
 public:
  Parser(std::string path, Structures& out, Constants& constants)
      : path_{std::move(path)}, tokens_{tokens_of(path_)}, out_{out}, constants_{constants} {}

  void parse() {
    while (at_ < tokens_.size()) definition();
  }

 private:
  void definition() {
    const std::string what = next();
    if (what == "module") {
      scope_.push_back(next());
      expect("{");
      while (peek() != "}") definition();
      expect("}");
      scope_.pop_back();
    } else if (what == "struct") {
      structure();
    } else if (what == "const") {
      constant();
    } else {
      fail("'" + what + "' is not one of module, struct, const");
    }
    expect(";");
  }

  // Outside of a structure's module it has no place in a message's definition.
  void constant() {
    Constant constant;
    const auto type = kBasicTypes.find(next());
    if (peek() == "<") {
      bound("<");
      expect(">");
    }
    constant.name = next();
    expect("=");
    while (peek() != ";") constant.value += next();
    std::string owner = scoped("");
    owner.pop_back();
    if (type == kBasicTypes.end() || !owner.ends_with(kConstants)) return;
    constant.type_id = type->second;
    constants_[owner.substr(0, owner.size() - kConstants.size())].push_back(constant);
  }

  void structure() {
    auto& fields = out_[scoped(next())];
    expect("{");
    while (peek() != "}") fields.push_back(field());
    expect("}");
  }

  Field field() {
    Field field;
    if (peek() == "@") field.default_value = default_value();
    if (peek() == "sequence") {
      next();
      expect("<");
      element(field);
      field.type_id += peek() == "," ? kBoundedSequence : kUnboundedSequence;
      if (peek() == ",") field.capacity = bound(",");
      expect(">");
    } else {
      element(field);
    }
    field.name = next();
    if (field.name.starts_with('_')) field.name.erase(0, 1);  // a reserved word, escaped
    if (peek() == "[") {
      field.capacity = bound("[");
      field.type_id += kArray;
      expect("]");
    }
    expect(";");
    return field;
  }

  // @default (value=1.0)
  std::string default_value() {
    for (const char* token : {"@", "default", "(", "value", "="}) expect(token);
    std::string value;
    while (peek() != ")") value += next();
    expect(")");
    return value;
  }

  void element(Field& field) {
    std::string name = next();
    const auto basic = kBasicTypes.find(name);
    if (basic != kBasicTypes.end()) {
      field.type_id = basic->second;
      if (peek() != "<") return;
      field.string_capacity = bound("<");
      field.type_id += kBoundedString;
      expect(">");
      return;
    }
    const bool is_relative = peek() != "::";
    while (peek() == "::") {
      next();
      name += "/" + next();
    }
    field.type_id = kNested;
    field.nested = is_relative ? scoped(name) : name;
  }

  long bound(const std::string& opening) {
    expect(opening);
    return std::stol(next());
  }

  [[nodiscard]] std::string scoped(const std::string& name) const {
    std::string full;
    for (const auto& module : scope_) full += module + "/";
    return full + name;
  }
  [[nodiscard]] const std::string& peek() const {
    if (at_ >= tokens_.size()) fail("ends too early");
    return tokens_[at_];
  }
  std::string next() {
    std::string token = peek();
    ++at_;
    return token;
  }
  void expect(const std::string& token) {
    if (const std::string got = next(); got != token) fail("'" + got + "' instead of " + token);
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(path_ + ": " + what);
  }

  std::string path_;
  std::vector<std::string> tokens_;
  Structures& out_;
  Constants& constants_;
  std::size_t at_ = 0;
  std::vector<std::string> scope_;
};

// Adds for each service that is not in `known` the type of its introspection events, as rosidl
// derives it.
void add_events(Structures& all, const Structures& known) {
  constexpr std::string_view kRequest = "_Request";
  const std::string info = "service_msgs/msg/ServiceEventInfo";
  if (!all.contains(info)) return;
  Structures events;
  for (const auto& [name, fields] : all) {
    if (!name.ends_with(kRequest) || known.contains(name)) continue;
    const std::string service = name.substr(0, name.size() - kRequest.size());
    const int sequence = kNested + kBoundedSequence;
    if (all.contains(service + "_Response"))
      events[service + "_Event"] = {{"info", kNested, 0, 0, info},
                                    {"request", sequence, 1, 0, name},
                                    {"response", sequence, 1, 0, service + "_Response"}};
  }
  all.merge(events);
}

std::string description(const std::string& name, const Structures& all) {
  std::string text = "{\"type_name\": \"" + name + "\", \"fields\": [";
  bool first = true;
  for (const Field& field : all.at(name)) {
    text += (first ? "" : ", ") + std::string{"{\"name\": \""} + field.name +
            "\", \"type\": {\"type_id\": " + std::to_string(field.type_id) +
            ", \"capacity\": " + std::to_string(field.capacity) +
            ", \"string_capacity\": " + std::to_string(field.string_capacity) +
            ", \"nested_type_name\": \"" + field.nested + "\"}}";
    first = false;
  }
  return text + "]}";
}

void collect_nested(const std::string& name, const Structures& all, std::set<std::string>& found) {
  if (!all.contains(name)) throw std::runtime_error("structure " + name + " is nowhere defined");
  for (const Field& field : all.at(name))
    if (!field.nested.empty() && found.insert(field.nested).second)
      collect_nested(field.nested, all, found);
}

std::string hash(const std::string& name, const Structures& all) {
  std::set<std::string> nested;
  collect_nested(name, all, nested);
  std::string text =
      "{\"type_description\": " + description(name, all) + ", \"referenced_type_descriptions\": [";
  bool first = true;
  for (const auto& other : nested) {
    text += (first ? "" : ", ") + description(other, all);
    first = false;
  }
  text += "]}";
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest);
  std::string result = "RIHS01_";
  for (const unsigned char byte : digest) {
    char hex[3];
    std::snprintf(hex, sizeof hex, "%02x", byte);
    result += hex;
  }
  return result;
}

// A value as it stands in a .msg file, as a string literal.
std::string literal(const std::string& value) {
  if (value == "TRUE") return "\"true\"";
  if (value == "FALSE") return "\"false\"";
  std::string text = "\"";
  for (const char c : value) text += (c == '"' || c == '\\' ? "\\" : "") + std::string{c};
  return text + "\"";
}

// Empty without constants, because C++ has no empty arrays.
std::string constants_array(const std::string& entries) {
  return entries.empty()
             ? ""
             : "constexpr DescribedConstant kDescribedConstants[] = {\n" + entries + "};\n\n";
}

// The structures of `all` that are not in `known`, as code.
std::string code(const Structures& all, const Structures& known, const Constants& constants) {
  std::ostringstream types, fields, values;
  std::size_t count = 0, constant_count = 0;
  for (const auto& [name, members] : all) {
    if (known.contains(name)) continue;
    types << "    {\"" << name << "\", \"" << hash(name, all) << "\", {kDescribedFields + " << count
          << ", " << members.size() << "}";
    if (const auto own = constants.find(name); own != constants.end()) {
      types << ", {kDescribedConstants + " << constant_count << ", " << own->second.size() << "}";
      constant_count += own->second.size();
      for (const Constant& constant : own->second)
        values << "    {\"" << constant.name << "\", " << constant.type_id << ", "
               << literal(constant.value) << "},\n";
    }
    types << "},\n";
    for (const Field& field : members)
      fields << "    {\"" << field.name << "\", " << field.type_id << ", " << field.capacity << ", "
             << field.string_capacity << ", \"" << field.nested << "\", "
             << literal(field.default_value) << "},\n";
    count += members.size();
  }
  return "#include \"type_hashes.hpp\"\n\n"
         "namespace tandem::runtime {\nnamespace {\n\n"
         "constexpr DescribedField kDescribedFields[] = {\n" +
         fields.str() + "};\n\n" + constants_array(values.str()) +
         "constexpr DescribedType kDescribedTypes[] = {\n" + types.str() +
         "};\n\n[[maybe_unused]] const bool types_are_described = "
         "add_described_types(kDescribedTypes);\n\n"
         "}  // namespace\n}  // namespace tandem::runtime\n";
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> files{argv + 2, argv + argc};
  const auto first_known = std::find(files.begin(), files.end(), "--known");
  Structures known;
  Constants constants;
  for (auto file = first_known; file != files.end(); ++file)
    if (file != first_known) Parser{*file, known, constants}.parse();
  Structures all = known;
  for (auto file = files.begin(); file != first_known; ++file)
    Parser{*file, all, constants}.parse();
  add_events(all, known);
  std::ofstream out{argv[1]};
  out << code(all, known, constants);
  return out.good() ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "hash_types: %s\n", error.what());
  return 1;
}
