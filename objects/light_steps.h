// How much of the light that objects receive and change is found in one frame.
#pragma once

namespace pleinair {

enum class LightSteps {
  kAll,      // All that is lacking.
  kFirst,    // No frame was before, and the next ones follow soon: a coarse step.
  kMoving,   // Objects have moved since the frame before: a coarse step.
  kResting,  // They have not: what is coarse is refined by a step.
};

}  // namespace pleinair
