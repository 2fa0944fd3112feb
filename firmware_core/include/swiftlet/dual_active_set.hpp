#pragma once
// placeholder, replaced by the trajectory work
namespace swiftlet { struct QpSpans {}; }
