#include <string_view>

namespace {

volatile int depth_wanted = 1'000'000;

/// Not a tail call, so that each level takes stack.
[[gnu::noinline]] int descend(int depth) {
  volatile int level = depth;
  return depth < depth_wanted ? descend(depth + 1) + level : level;
}

}  // namespace

/// Faults as its argument says; a start-up code that works ends each with exit status 255.
int main(int argc, char** argv) {
  const std::string_view kind = argc > 1 ? argv[1] : "none";
  if (kind == "stack") return descend(0);
  if (kind == "address") return *reinterpret_cast<volatile int*>(0x30000000);
  return 0;
}
