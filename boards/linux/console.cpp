#include "linux/console.hpp"

#include <charconv>
#include <cmath>
#include <vector>

namespace swiftlet::board {
namespace {

using companion::Word;

std::vector<std::string_view> split(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\n,";
  std::vector<std::string_view> pieces;
  std::size_t first = line.find_first_not_of(kBlanks);
  while (first != std::string_view::npos) {
    const std::size_t end = line.find_first_of(kBlanks, first);
    pieces.push_back(line.substr(first, end - first));
    first = line.find_first_not_of(kBlanks, end);
  }
  return pieces;
}

/// All pieces but the first as finite numbers.
std::optional<std::vector<Real>> numbers(const std::vector<std::string_view>& pieces) {
  std::vector<Real> list;
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    double number = 0;
    const char* end = pieces[i].data() + pieces[i].size();
    const auto [read, error] = std::from_chars(pieces[i].data(), end, number);
    if (error != std::errc() || read != end || !std::isfinite(number)) return std::nullopt;
    list.push_back(static_cast<Real>(number));
  }
  return list;
}

std::optional<std::uint32_t> whole(Real number) {
  if (!(number >= 0 && number <= Real(1e9)) || number != std::floor(number)) return std::nullopt;
  return static_cast<std::uint32_t>(number);
}

std::optional<Word> simple_word(std::string_view name) {
  if (name == "engage") return Word{.kind = Word::Kind::kEngage};
  if (name == "release") return Word{.kind = Word::Kind::kRelease};
  if (name == "stop") return Word{.kind = Word::Kind::kStop};
  if (name == "land") return Word{.kind = Word::Kind::kLand};
  return std::nullopt;
}

std::optional<Word> word_with_numbers(std::string_view name, const std::vector<Real>& n) {
  Word word;
  if ((name == "goal" || name == "goto") && (n.size() == 3 || n.size() == 4)) {
    word.kind = name == "goal" ? Word::Kind::kAddGoal : Word::Kind::kSetGoal;
    word.a = {n[0], n[1], n[2]};
    if (n.size() == 4) word.yaw = n[3];
    return word;
  }
  if (name == "limits" && n.size() == 2) {
    word.kind = Word::Kind::kLimits;
    word.a = {n[0], n[1], 0};
    return word;
  }
  const std::optional<std::uint32_t> id = n.empty() ? std::nullopt : whole(n[0]);
  if (!id) return std::nullopt;
  word.id = *id;
  if (name == "block" && n.size() == 7) {
    word.kind = Word::Kind::kBlock;
    word.a = Vector3{n[1], n[2], n[3]}.cwiseMin(Vector3{n[4], n[5], n[6]});
    word.b = Vector3{n[1], n[2], n[3]}.cwiseMax(Vector3{n[4], n[5], n[6]});
    return word;
  }
  if (name == "unblock" && n.size() == 1) {
    word.kind = Word::Kind::kUnblock;
    return word;
  }
  return std::nullopt;
}

}  // namespace

std::optional<ConsoleLine> parse_line(std::string_view line) {
  const std::vector<std::string_view> pieces = split(line);
  if (pieces.empty()) return std::nullopt;
  const std::string_view name = pieces[0];
  if (pieces.size() == 1) {
    if (name == "status") return Query::kStatus;
    if (name == "help") return Query::kHelp;
    if (name == "quit") return Query::kQuit;
    if (const std::optional<Word> word = simple_word(name)) return *word;
    return std::nullopt;
  }
  if (name == "map" && pieces.size() == 2) return NewMap{std::string(pieces[1])};
  const std::optional<std::vector<Real>> list = numbers(pieces);
  if (!list) return std::nullopt;
  if (const std::optional<Word> word = word_with_numbers(name, *list)) return *word;
  return std::nullopt;
}

}  // namespace swiftlet::board
