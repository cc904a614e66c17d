// The order in which both wheels stand on the serial line and in arrays.
#pragma once

enum wheel { LEFT, RIGHT, WHEEL_COUNT };
