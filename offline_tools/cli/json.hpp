#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace swiftlet::tools {

/// Keys keep the order in which they are written; doubles print with the digits that read back the same double, and
/// non-finite ones as null.
using Json = nlohmann::ordered_json;

/// One line. Text that is not UTF-8 (a file name may be anything) is replaced, not refused.
inline std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace swiftlet::tools
