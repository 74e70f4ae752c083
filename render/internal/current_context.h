// Which OpenGL context is current, without the headers of any of its libraries.
#pragma once

namespace pleinair {

// This thread's EGL context; null where there is none. Two contexts that live at once differ.
const void* CurrentContext();

}  // namespace pleinair
