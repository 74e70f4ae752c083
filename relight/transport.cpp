#include "relight/transport.h"
