// A seeded violation: printing a double brings malloc. Must not link on a bare board.
#include <cstdio>

char text[64];

int main(int argc, char** /*argv*/) { return std::snprintf(text, sizeof text, "%f", 0.5 * argc); }
