#pragma once
#include <string_view>

namespace swiftlet::tools {

/// The viewer's page, bundled by viewer/build.js, in the pieces around what differs from report to report: the title
/// (HTML text) and the data (JSON inside a script element). Defined in a source that is generated at build time.
extern const std::string_view kPageBeforeTitle;
extern const std::string_view kPageBeforeData;
extern const std::string_view kPageEnd;

}  // namespace swiftlet::tools
