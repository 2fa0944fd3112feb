#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "swiftlet/brake.hpp"
#include "swiftlet/certificate.hpp"
#include "swiftlet/flight_time.hpp"
#include "swiftlet/trajectory.hpp"
#include "swiftlet/types.hpp"

namespace swiftlet {

/// Where the next plan must start: in `state`, which the reference will have at `start`. A splice is good for one
/// offer, and only while the reference stays what it was.
struct Splice {
  TimeUs start = 0;
  State state;
  std::uint32_t id = 0;
};

/// What became of an offered plan.
enum class OfferResult : std::uint8_t {
  kAccepted,       ///< it is flown from splice.start on
  kLate,           ///< splice.start has passed: the result came too late and is discarded
  kSuperseded,     ///< another splice was made since, or the reference changed (brake, hold, shift)
  kNotCertified,   ///< its certificate does not pass
  kTooLong,        ///< more segments than a slot holds, or none
  kDiscontinuous,  ///< it does not start in the splice's state, or does not end at rest
};

/// English phrase for people and logs.
const char* describe(OfferResult result);

/// A finished plan, offered to the store.
struct PlanOffer {
  std::span<const Segment> segments;
  Certificate certificate;
  BrakeLimits limits;  ///< that the certificate was issued for; a brake keeps them
};

/// The two slots, at least one segment each; the same length is sensible. Contents irrelevant.
struct StoreSpans {
  std::array<std::span<Segment>, 2> slots;
};

/// Memory of a store for plans of up to `kSegments` segments, trivially destructible.
template <std::size_t kSegments>
class TrajectorySlots {
 public:
  StoreSpans spans() { return {{slots_[0], slots_[1]}}; }

 private:
  std::array<std::array<Segment, kSegments>, 2> slots_;
};

/// What the vehicle is to do at any time: the committed trajectory, and the candidate that takes over at a stated time
/// from the state sampled from the committed one (a splice). The last committed trajectory ends at rest in known free
/// space, so whatever fails, there is an answer. After its end the reference holds. Sampling changes nothing.
class TrajectoryStore {
 public:
  explicit TrajectoryStore(const StoreSpans& spans) : spans_(spans) {}

  /// Rest at `position` [m] from now on, at once: before a take-off, or where the vehicle was found. Drops everything
  /// else.
  void hold(const Vector3& position, TimeUs now);

  /// True once there is anything to fly.
  [[nodiscard]] bool has_reference() const { return committed_.used; }

  /// The splice for a plan that will be offered within `latency` (the worst case, not the mean). Refused (id 0) without
  /// a reference and while a candidate waits for its start: three plans cannot be in flight at once.
  Splice begin(TimeUs now, TimeUs latency);

  /// Takes a plan over entire or not at all, in bounded time, checking what it says: the certificate passes, it fits,
  /// it starts in the splice's state within the certificate's own limits for a jump, ends at rest, and is in time.
  OfferResult offer(const PlanOffer& plan, const Splice& splice, TimeUs now);

  /// The reference at `time`; `time` before the oldest trajectory kept gives its start.
  [[nodiscard]] Sample sample(TimeUs time) const;

  /// Slows the reference down to rest from `now` on, along the committed path and within its certificate's limits
  /// (find_brake). A candidate that has not started is dropped. While a brake is under way this changes nothing.
  void brake(TimeUs now);

  /// The path time from `from` to the end or the brake's stop is over: the reference is at rest for good.
  [[nodiscard]] bool at_rest(TimeUs time) const;

  /// The caller's clock jumped by `jump`: the reference goes on where it was.
  void shift_clock(TimeUs jump);

  /// The estimate of position jumped by `jump` [m]: the reference moves along, so that the vehicle does not lunge.
  /// Lasts until the next plan or hold. The path then lies beside its corridor in map coordinates; see docs/flight.md.
  void shift_position(const Vector3& jump);

  /// The segments that are flown, or will be, at `time`; and the path time there [s]. Empty while holding a point.
  [[nodiscard]] std::span<const Segment> segments(TimeUs time) const;
  [[nodiscard]] Real path_time_at(TimeUs time) const;

 private:
  struct Slot {
    std::size_t index = 0;  // of the span that holds the segments
    std::size_t count = 0;  // 0: rest at `offset`
    TimeUs start = 0;
    TimeUs brake_start = 0;
    BrakeProfile brake;
    bool braking = false;
    bool used = false;
    Vector3 offset = Vector3::Zero();
    BrakeLimits limits;
  };

  void promote(TimeUs now);
  [[nodiscard]] const Slot& slot_at(TimeUs time) const;
  [[nodiscard]] std::span<const Segment> segments_of(const Slot& slot) const {
    return spans_.slots[slot.index].first(slot.count);
  }
  [[nodiscard]] static PathTime path_time_of(const Slot& slot, TimeUs time);

  StoreSpans spans_;
  Slot committed_;
  Slot candidate_;
  std::uint32_t splice_id_ = 0;
  bool splice_open_ = false;
};

}  // namespace swiftlet
