// How much of the light that objects receive and change is found in one frame.
#pragma once

namespace pleinair {

enum class LightSteps {
  kAll,      // All that is lacking.
  kFirst,    // There was no frame before, and more follow soon: a coarse step.
  kMoving,   // Objects have moved since the frame before: a coarse step.
  kResting,  // Objects have not moved: a step refines coarse light.
};

}  // namespace pleinair
