#pragma once
#include <string>

#include "swiftlet/hal/storage.hpp"

namespace swiftlet::hal {

/// Files of one folder.
class FileStorage final : public Storage {
 public:
  /// `folder` must exist.
  explicit FileStorage(std::string folder);
  ~FileStorage();
  FileStorage(const FileStorage&) = delete;
  FileStorage& operator=(const FileStorage&) = delete;

  std::optional<std::size_t> read(std::string_view name, std::size_t offset, std::span<std::byte> into) override;
  bool append(std::string_view name, std::span<const std::byte> bytes) override;
  bool remove(std::string_view name) override;

 private:
  [[nodiscard]] std::string path_of(std::string_view name) const;
  void close_appended();

  std::string folder_;
  std::string appended_name_;  // kept open: a log appends many times a second
  int appended_ = -1;
};

}  // namespace swiftlet::hal
