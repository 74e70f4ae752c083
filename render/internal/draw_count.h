// Counts draw calls: a measure of a frame's cost without a clock.
#pragma once

namespace pleinair {

// One draw call of this thread's, whose context is current.
void CountDraw();
// Since the last call.
int TakeDrawCount();

}  // namespace pleinair
