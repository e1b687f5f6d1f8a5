#include "firmware/sequencer/chip.hpp"

#include "firmware/sequencer/rp2040.hpp"
#include "firmware/sequencer/wiring.hpp"

namespace strobe::sequencer {
namespace {

void start_blocks(std::uint32_t blocks) {
  RESETS_RESET.set(blocks);
  RESETS_RESET.clear(blocks);
  RESETS_RESET_DONE.wait_for(blocks);
}

/// 12 MHz x 125 / (6 x 2) = 125 MHz.
void start_pll() {
  start_blocks(bit(kResetPllSys));
  PLL_SYS_CS.write(1);  // REFDIV
  PLL_SYS_FBDIV_INT.write(125);
  PLL_SYS_PWR.clear(bit(0) | bit(5));  // PD, VCOPD
  PLL_SYS_CS.wait_for(bit(31));        // LOCK
  PLL_SYS_PRIM.write(6U << 16 | 2U << 12);
  PLL_SYS_PWR.clear(bit(3));  // POSTDIVPD
}

void set_clocks() {
  CLK_SYS_RESUS_CTRL.write(0);
  XOSC_CTRL.write(0xaa0);  // 1 to 15 MHz
  XOSC_STARTUP.write(47);  // x 256 cycles: 1 ms
  XOSC_CTRL.write(0xfabU << 12 | 0xaa0);
  XOSC_STATUS.wait_for(bit(31));  // STABLE

  CLK_SYS_CTRL.clear(bit(0));  // away from the PLL while it changes
  CLK_SYS_SELECTED.wait_for(bit(0));
  start_pll();
  CLK_REF_CTRL.write(2);  // XOSC
  CLK_REF_SELECTED.wait_for(bit(2));
  CLK_SYS_CTRL.write(0);  // the PLL as the other source, ...
  CLK_SYS_CTRL.set(bit(0));
  CLK_SYS_SELECTED.wait_for(bit(1));  // ... and on to it
  CLK_PERI_CTRL.write(bit(11));       // ENABLE, from clk_sys
  WATCHDOG_TICK.write(bit(9) | 12);   // ENABLE, 1 us of clk_ref
}

void set_uart() {
  pad(kRxPin).set(kPadPullUp);  // an unplugged cable is silent
  pad(kRxPin).clear(kPadPullDown);
  UARTIBRD.write(7);  // 125 MHz / (16 x (7 + 52/64)) = 1 MHz
  UARTFBRD.write(52);
  UARTLCR_H.write(3U << 5 | bit(4));       // 8 bits, FIFOs
  UARTCR.write(bit(0) | bit(8) | bit(9));  // UARTEN, TXE, RXE
  UARTDMACR.write(bit(0));                 // RXDMAE
  for (const unsigned pin : {kTxPin, kRxPin})
    gpio_ctrl(pin).write(static_cast<std::uint32_t>(Function::uart));
}

}  // namespace

void set_up_chip() {
  set_clocks();
  start_blocks(bit(kResetBusctrl) | bit(kResetDma) | bit(kResetIoBank0) | bit(kResetPadsBank0) |
               bit(kResetPio0) | bit(kResetPio1) | bit(kResetTimer) | bit(kResetUart0));
  BUS_PRIORITY.write(bit(8) | bit(12));  // the DMA's reads and writes before the processor's
  set_uart();
  SYST_RVR.write(0xffffff);
  SYST_CVR.write(0);
  SYST_CSR.write(bit(0) | bit(2));  // ENABLE, of the processor's clock
  for (const unsigned pin : {kStartPin, kLedPin}) {
    GPIO_OUT_CLR.write(bit(pin));
    GPIO_OE_SET.write(bit(pin));
    gpio_ctrl(pin).write(static_cast<std::uint32_t>(Function::sio));
  }
}

bool started_by_watchdog() { return (WATCHDOG_REASON.read() & bit(0)) != 0; }

void feed_watchdog() { WATCHDOG_LOAD.write(2 * kWatchdog_us); }  // it counts down twice each us (RP2040-E1)

void start_watchdog() {
  WATCHDOG_CTRL.clear(bit(30));
  PSM_WDSEL.write(0x1ffff & ~(bit(0) | bit(1)));  // resets all but the oscillators
  feed_watchdog();
  WATCHDOG_CTRL.clear(bit(24) | bit(25) | bit(26));  // no pause, not for a debugger either
  WATCHDOG_CTRL.set(bit(30));
}

std::uint32_t random_bits() {
  std::uint32_t bits = 0;
  for (int i = 0; i < 32; ++i) {
    bits = bits << 1 | (ROSC_RANDOMBIT.read() & 1);
    for (int wait = 0; wait < 4; ++wait) (void)SYST_CVR.read();  // the next bit is another period's
  }
  return bits * 2654435761U ^ SYST_CVR.read();
}

}  // namespace strobe::sequencer
