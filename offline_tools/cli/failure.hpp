#pragma once
#include <string>
#include <utility>

#include "map/error.hpp"

namespace swiftlet::tools {

/// Exit statuses of the program (contract.md).
enum class ExitStatus {
  kDone = 0,
  kNoAnswer = 1,  ///< the request has no answer
  kUsage = 2,     ///< the command line
  kBadFile = 3,   ///< an input that cannot be read or is not valid, an output that cannot be written
  kInternal = 4,  ///< a defect of ours
};

/// Ends a command: `main` prints `line`, which says what, where and what to do, and exits with `status`.
struct Failure {
  ExitStatus status;
  std::string line;
};

/// The value, or its Error as a Failure.
template <typename T>
T unwrap(Expected<T>&& result) {
  if (!result) throw Failure{static_cast<ExitStatus>(result.error().exit_status), result.error().message};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace swiftlet::tools
