// Order of the wheels on the serial line and in arrays.
#pragma once

enum wheel { LEFT, RIGHT, WHEEL_COUNT };
