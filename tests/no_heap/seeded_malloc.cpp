// A seeded violation: must not link on a bare board, and the symbol check must see it.
#include <cstdlib>

void* volatile sink;  // the compiler removes an allocation that does not escape

int main(int /*argc*/, char** /*argv*/) {
  sink = std::malloc(64);
  return 0;
}
