#include "report/page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>

#include "report/page_template.hpp"

namespace swiftlet::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char character : text) {
    switch (character) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += character;
    }
  }
  return escaped;
}

/// JSON that may stand inside a script element: no `<`, so neither an end tag nor a comment. Bytes that are not UTF-8
/// (a path may hold any) are replaced.
std::string script_json(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string escaped;
  escaped.reserve(text.size());
  for (const char character : text) {
    if (character == '<') {
      escaped += "\\u003c";
    } else {
      escaped += character;
    }
  }
  return escaped;
}

}  // namespace

std::string page(const std::string& title, const Json& report) {
  std::string html(kPageBeforeTitle);
  html += escape_html(title);
  html += kPageBeforeData;
  html += script_json(report);
  html += kPageEnd;
  return html;
}

std::string encode_integers(std::span<const std::uint16_t> integers) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t bytes = 2 * integers.size();
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    if (i >= bytes) return 0;
    return i % 2 == 0 ? integers[i / 2] & 0xFFU : static_cast<std::uint32_t>(integers[i / 2]) >> 8U;
  };
  std::string text;
  text.reserve((bytes + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes; i += 3) {
    const std::uint32_t three = byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2);
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[(three >> shift) & 63U];
  }
  const std::size_t padding = (3 - bytes % 3) % 3;
  return text.replace(text.size() - padding, padding, padding, '=');
}

std::string encode_boxes(std::span<const IntBox> boxes) {
  std::vector<std::uint16_t> corners;
  corners.reserve(boxes.size() * 6);
  for (const IntBox& box : boxes) {
    corners.insert(corners.end(), box.lo.begin(), box.lo.end());
    corners.insert(corners.end(), box.hi.begin(), box.hi.end());
  }
  return encode_integers(corners);
}

Json channel_json(std::span<const double> values) {
  constexpr std::uint16_t kNone = 65535;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  const double step = high > low ? (high - low) / (kNone - 1) : 1;
  std::vector<std::uint16_t> integers;
  integers.reserve(values.size());
  for (const double value : values) {
    integers.push_back(std::isfinite(value) ? static_cast<std::uint16_t>(std::lround((value - low) / step)) : kNone);
  }
  return {{"low", std::isfinite(low) ? low : 0}, {"step", step}, {"values", encode_integers(integers)}};
}

std::uint64_t volume(const IntBox& box) {
  std::uint64_t product = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) product *= static_cast<std::uint64_t>(box.hi[axis] - box.lo[axis]);
  return product;
}

std::vector<std::size_t> largest_items(std::size_t count, std::size_t most,
                                       const std::function<std::uint64_t(std::size_t)>& size_of) {
  std::vector<std::size_t> kept(count);
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  if (count <= most) return kept;
  std::stable_sort(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) { return size_of(a) > size_of(b); });
  kept.resize(most);
  return kept;
}

Json obstacles_json(const GridBoxes& obstacles, std::size_t most) {
  if (obstacles.boxes.empty()) return nullptr;
  std::vector<IntBox> shown;
  for (const std::size_t i :
       largest_items(obstacles.boxes.size(), most, [&](std::size_t at) { return volume(obstacles.boxes[at]); })) {
    shown.push_back(obstacles.boxes[i]);
  }
  return {{"count", obstacles.boxes.size()}, {"shown", shown.size()},         {"origin", obstacles.origin},
          {"unit", obstacles.unit},          {"voxel", obstacles.resolution}, {"boxes", encode_boxes(shown)}};
}

}  // namespace swiftlet::tools
