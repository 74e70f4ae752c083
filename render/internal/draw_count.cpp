#include "render/internal/draw_count.h"

#include <utility>

namespace pleinair {
namespace {

// A context is current on one thread.
thread_local int g_draws = 0;

}  // namespace

void CountDraw() { ++g_draws; }

int TakeDrawCount() { return std::exchange(g_draws, 0); }

}  // namespace pleinair
