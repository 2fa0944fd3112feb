#include "swiftlet/status.hpp"

namespace swiftlet {

const char* describe(Status status) {
  switch (status) {
    case Status::kOk:
      return "optimal";
    case Status::kFallback:
      return "fallback";
    case Status::kStartNotFree:
      return "start_not_free";
    case Status::kGoalNotFree:
      return "goal_not_free";
    case Status::kNoPath:
      return "no_path";
    case Status::kSearchCapacity:
      return "search_capacity";
    case Status::kCorridorCapacity:
      return "corridor_capacity";
    case Status::kInfeasible:
      return "infeasible";
    case Status::kBadRequest:
      return "bad_request";
    case Status::kIterationLimit:
      return "the solver met its iteration cap";
    case Status::kNumericalTrouble:
      return "the solver ran out of digits";
    case Status::kBufferTooSmall:
      return "a buffer is too small for the result";
    case Status::kBlobTruncated:
      return "the map is cut short";
    case Status::kBlobWrongMagic:
      return "this is not a swiftlet map";
    case Status::kBlobWrongByteOrder:
      return "the map was written for another byte order";
    case Status::kBlobWrongVersion:
      return "the map has another format version";
    case Status::kBlobDamaged:
      return "the map is damaged: its checksum does not match";
    case Status::kBlobInconsistent:
      return "the map contradicts itself: an index, an order or a size is out of range";
  }
  return "unknown status";
}

}  // namespace swiftlet
