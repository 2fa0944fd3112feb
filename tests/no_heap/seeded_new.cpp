// A seeded violation: must not link on a bare board, and the symbol check must see it.
double* volatile sink;  // the compiler removes an allocation that does not escape

int main(int /*argc*/, char** /*argv*/) {
  sink = new double[64];
  delete[] sink;
  return 0;
}
