#pragma once
#include <string>
#include <tl/expected.hpp>

namespace swiftlet::tools {

/// Why an offline tool stopped: its exit status (contract.md) and one line that says what, where and what to do.
struct Error {
  int exit_status;
  std::string message;
};

template <typename T>
using Expected = tl::expected<T, Error>;

inline constexpr int kExitUsage = 2;
inline constexpr int kExitBadFile = 3;

/// An option's number that this input cannot be used with.
inline tl::unexpected<Error> bad_option(std::string message) {
  return tl::unexpected(Error{kExitUsage, std::move(message)});
}

inline tl::unexpected<Error> bad_file(std::string message) {
  return tl::unexpected(Error{kExitBadFile, std::move(message)});
}

}  // namespace swiftlet::tools
