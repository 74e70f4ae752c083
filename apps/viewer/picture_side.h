// Which of the pictures in the window is meant.
#pragma once

namespace pleinair {

enum class PictureSide { kCamera, kOther };

}  // namespace pleinair
