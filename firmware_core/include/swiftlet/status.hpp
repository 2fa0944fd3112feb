#pragma once
#include <cstdint>

namespace swiftlet {

/// Every way in which a call of the core can end. Running out is an ordinary answer; nothing here is exceptional.
enum class [[nodiscard]] Status : std::uint8_t{
    kOk,                  ///< Done; for a plan: each axis is at its optimum.
    kFallback,            ///< A certified answer that is not the optimum; the report names the reason.
    kStartNotFree,        ///< The start lies in no cell of the map.
    kGoalNotFree,         ///< The goal lies in no cell of the map.
    kNoPath,              ///< Start and goal are not connected through free space.
    kSearchCapacity,      ///< The search ran out of nodes; a board with more of them may find a path.
    kCorridorCapacity,    ///< The corridor has more boxes than the board holds segments.
    kInfeasible,          ///< No trajectory exists for these boxes, times and limits (at zero margins).
    kBadRequest,          ///< Non-finite, non-positive or contradictory numbers in the request.
    kIterationLimit,      ///< The solver met its iteration cap.
    kNumericalTrouble,    ///< The solver ran out of digits.
    kBufferTooSmall,      ///< A caller's buffer cannot hold the result; nothing was written.
    kBlobTruncated,       ///< The blob is shorter than its header, or than the header says.
    kBlobWrongMagic,      ///< Not a swiftlet map.
    kBlobWrongByteOrder,  ///< A map written for another byte order.
    kBlobWrongVersion,    ///< A map of another format version.
    kBlobDamaged,         ///< The checksum does not match: the blob is damaged.
    kBlobInconsistent,    ///< The checksum matches but an index, an order or a size is out of range.
};

/// A small T, or the Status that says why there is none. Check `ok()` before `*`.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(const T& value) : value_(value), status_(Status::kOk) {}  // NOLINT(google-explicit-constructor)
  Result(Status status) : status_(status) {}                       // NOLINT(google-explicit-constructor)
  [[nodiscard]] bool ok() const { return status_ == Status::kOk; }
  [[nodiscard]] Status status() const { return status_; }
  const T& operator*() const { return value_; }
  const T* operator->() const { return &value_; }

 private:
  T value_{};
  Status status_;
};

/// The contract's word for a status of a plan ("optimal", "no_path", ...); for any other status a short English phrase.
const char* describe(Status status);

}  // namespace swiftlet
