#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "swiftlet/box_graph_view.hpp"

namespace swiftlet::tools {

/// The same map under another CRC-32, as if it came from another file: what a simulated flight is given as its new map.
class RenamedMap {
 public:
  explicit RenamedMap(const BoxGraphView& map) : words_((map.bytes().size() + 7) / 8) {
    const std::span<std::byte> bytes = std::as_writable_bytes(std::span(words_)).first(map.bytes().size());
    std::copy(map.bytes().begin(), map.bytes().end(), bytes.begin());
    BlobHeader header = map.header();
    ++header.source_digest[0];
    std::memcpy(bytes.data(), &header, sizeof(header));
    header.crc32 = blob_crc32(bytes);
    std::memcpy(bytes.data(), &header, sizeof(header));
    view_ = *BoxGraphView::open(bytes);
  }
  [[nodiscard]] const BoxGraphView& view() const { return view_; }

 private:
  std::vector<std::uint64_t> words_;
  BoxGraphView view_;
};

}  // namespace swiftlet::tools
