// SPDX-License-Identifier: Apache-2.0
#include "tandem/driver/script_phase.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <stdexcept>

namespace tandem {
namespace {

constexpr double kFarthest = 1e4;  // [m] limit of a coordinate
constexpr double kLongest = 1e4;   // [s] limit of a phase

[[noreturn]] void fail(const std::string& what) { throw std::invalid_argument(what); }

// Distances from base_link to the outline's edges [m], by name.
std::map<std::string, double> edges_of(const Footprint& outline) {
  const Extent e = extent(outline);
  return {{"front", e.front}, {"rear", e.rear}, {"left", e.left}, {"right", e.right}};
}

// Reads the words of one phase in order.
class PhaseReader {
 public:
  PhaseReader(const std::string& text, const std::map<std::string, double>& edges)
      : words_{text}, edges_{edges} {
    next();
  }

  ScriptPhase read() {
    const std::string kind = word("path, turn, hold or push");
    if (kind == "path") return path();
    if (kind == "turn") return turn();
    if (kind == "hold") return finished({PushPhase{}, number("a time", 0.0, kLongest)});
    if (kind == "push") return push();
    fail("`" + kind + "` is not one of path, turn, hold, push");
  }

 private:
  void next() {
    if (!(words_ >> word_)) word_.clear();
  }

  std::string word(const std::string& expected) {
    if (word_.empty()) fail("ends where " + expected + " is expected");
    std::string taken = word_;
    next();
    return taken;
  }

  bool take(const std::string& wanted) {
    if (word_ != wanted) return false;
    next();
    return true;
  }

  double number(const std::string& what, double low, double high) {
    const std::string text = word(what);
    const double value = sum(text);
    if (value >= low && value <= high) return value;
    std::ostringstream line;
    line << "`" << text << "` is not " << what << " in [" << low << ", " << high << "]";
    fail(line.str());
  }

  // Evaluates a sum of numbers and edge names; NaN if it is malformed.
  double sum(const std::string& text) const {
    double total = 0.0;
    for (std::size_t begin = 0; begin < text.size();) {
      const double sign = text[begin] == '-' ? -1.0 : 1.0;
      if (text[begin] == '-' || text[begin] == '+') ++begin;
      const std::size_t end = std::min(text.find_first_of("+-", begin), text.size());
      total += sign * term(text.substr(begin, end - begin));
      begin = end;
    }
    return total;
  }

  double term(const std::string& text) const {
    if (const auto edge = edges_.find(text); edge != edges_.end()) return edge->second;
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    return text.empty() || *end != '\0' ? std::nan("") : value;
  }

  double stick() { return number("a fraction of the stick's travel", 0.0, 1.0); }
  double timeout() { return number("a time", 0.0, kLongest); }

  ScriptPhase path() {
    const std::string direction = word("forward or back");
    if (direction != "forward" && direction != "back")
      fail("`" + direction + "` is neither forward nor back");
    const double share = stick();
    double end = std::min(share, 0.15), tolerance = 0.05, time = 30.0;
    bool leader = false;
    while (!take("via")) {
      if (take("to"))
        end = stick();
      else if (take("within"))
        tolerance = number("a tolerance", 0.0, kFarthest);
      else if (take("for"))
        time = timeout();
      else if (take("leader"))
        leader = true;
      else
        fail("`" + word("`via` and the route's points") +
             "` is not one of to, within, for, leader, "
             "via");
    }
    return {PathPhase{route(), direction == "back" ? -1.0 : 1.0, share, end, tolerance, leader},
            time};
  }

  Route route() {
    std::vector<Eigen::Vector2d> points;
    while (!word_.empty()) {
      const double x = number("a coordinate", -kFarthest, kFarthest);
      points.emplace_back(x, number("a coordinate", -kFarthest, kFarthest));
    }
    return Route{std::move(points)};
  }

  ScriptPhase turn() {
    TurnPhase turn;
    ScriptPhase phase;
    turn.heading = number("a heading", -kFarthest, kFarthest);
    while (!word_.empty()) {
      if (take("stick"))
        turn.stick = stick();
      else if (take("within"))
        turn.tolerance = number("a tolerance", 0.0, kFarthest);
      else if (take("for"))
        phase.time = timeout();
      else
        fail("`" + word_ + "` is not one of stick, within, for");
    }
    phase.action = turn;
    return phase;
  }

  ScriptPhase push() {
    PushPhase push;
    push.linear = number("a fraction of the stick's travel", -1.0, 1.0);
    push.angular = number("a fraction of the stick's travel", -1.0, 1.0);
    return finished({push, timeout()});
  }

  ScriptPhase finished(const ScriptPhase& phase) const {
    if (!word_.empty()) fail("`" + word_ + "` is unexpected; the phase is already complete");
    return phase;
  }

  std::istringstream words_;
  std::string word_;
  const std::map<std::string, double>& edges_;
};

std::string without_comments(std::string text) {
  for (auto begin = text.find('#'); begin != std::string::npos; begin = text.find('#', begin))
    text.erase(begin, std::min(text.find('\n', begin), text.size()) - begin);
  return text;
}

bool is_blank(const std::string& text) {
  return text.find_first_not_of(" \t\r\n") == std::string::npos;
}

}  // namespace

std::vector<ScriptPhase> read_script(const std::string& script, const Footprint& outline) {
  const std::string text = without_comments(script);
  const auto edges = edges_of(outline);
  std::vector<ScriptPhase> phases;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(";\n", begin), text.size());
    const std::string phase = text.substr(begin, end - begin);
    begin = end + 1;
    if (is_blank(phase)) continue;
    try {
      phases.push_back(PhaseReader{phase, edges}.read());
    } catch (const std::invalid_argument& error) {
      fail("script, phase " + std::to_string(phases.size() + 1) + ": " + error.what());
    }
  }
  if (phases.empty()) fail("script: needs at least one phase: path, turn, hold or push");
  return phases;
}

}  // namespace tandem
