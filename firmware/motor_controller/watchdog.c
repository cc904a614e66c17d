#include "watchdog.h"

#include <avr/io.h>
#include <avr/wdt.h>

// After a watchdog reset the watchdog stays enabled with its shortest timeout; disable it before memory is initialized.
static void stop_after_reset(void) __attribute__((naked, used, section(".init3")));

static void stop_after_reset(void)
{
    MCUSR = 0;
    wdt_disable();
}

void watchdog_begin(void)
{
    wdt_enable(WDTO_120MS);
}

void watchdog_reset(void)
{
    wdt_reset();
}
