#pragma once
#include <cstdint>
#include <string>

namespace swiftlet::board {

/// The time of a key's signatures [10 us since 2015], kept in a file beside the key: it never repeats, whatever the
/// board's clock says after a start. What is kept lies ahead of what was used, so that the power may go at any time.
class SigningTime {
 public:
  static constexpr std::uint64_t kAhead = 6'000'000;  // a minute; kept anew when half of it is used

  /// Of the key in the file `key_path`. Throws tools::Failure when what is kept is no time.
  explicit SigningTime(const std::string& key_path);

  /// The time to begin with: above all that was used, not below `clock`.
  [[nodiscard]] std::uint64_t first(std::uint64_t clock) const { return clock > kept_ ? clock : kept_; }
  /// `used`: the newest so far. Before the first signature, then at least every ten seconds. Throws tools::Failure when
  /// it cannot be kept.
  void keep(std::uint64_t used);
  /// After the last signature: nothing ahead is needed any more.
  void end(std::uint64_t used) { write(used); }

 private:
  void write(std::uint64_t time);

  std::string path_;
  std::uint64_t kept_ = 0;
  bool written_ = false;
};

}  // namespace swiftlet::board
