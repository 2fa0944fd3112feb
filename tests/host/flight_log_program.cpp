// Writes the sample log into the folder that it is given: for flight_log_peer.py.
#include "sample_flight_log.hpp"
#include "swiftlet/hal/file_storage.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  swiftlet::hal::FileStorage storage(argv[1]);
  swiftlet::companion::FlightLog log(storage);
  storage.remove("sample.ulg");
  swiftlet::companion::write_sample(log, "sample.ulg");
  return log.full() ? 1 : 0;
}
