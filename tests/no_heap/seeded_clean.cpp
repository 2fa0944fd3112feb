// Links: shows that the seeded violations beside it fail for their heap alone.
int main(int /*argc*/, char** /*argv*/) { return 0; }
