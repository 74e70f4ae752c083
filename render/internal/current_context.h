// Which OpenGL context is current, without the headers of any of its libraries.
#pragma once

namespace pleinair {

// Of EGL, on this thread; null where there is none. Two contexts that live at once differ.
const void* CurrentContext();

}  // namespace pleinair
