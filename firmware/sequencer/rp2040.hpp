// The registers of the RP2040 that the sequencer uses, by the names of its datasheet (build-date 2023-03-02).
#pragma once

#include <cstdint>

namespace strobe::sequencer {

/// A register of 32 bits. Peripherals but for SIO and the core's own have aliases that set and clear bits.
class Register {
 public:
  explicit constexpr Register(std::uint32_t address) : address_(address) {}
  std::uint32_t read() const { return *at(address_); }
  void write(std::uint32_t value) const { *at(address_) = value; }
  void set(std::uint32_t bits) const { *at(address_ + 0x2000) = bits; }
  void clear(std::uint32_t bits) const { *at(address_ + 0x3000) = bits; }
  void wait_for(std::uint32_t bits) const {
    while ((read() & bits) != bits) {
    }
  }
  constexpr std::uint32_t address() const { return address_; }
  constexpr Register operator+(std::uint32_t offset) const { return Register(address_ + offset); }

 private:
  static volatile std::uint32_t* at(std::uint32_t address) {
    return reinterpret_cast<volatile std::uint32_t*>(address);
  }
  std::uint32_t address_;
};

inline constexpr std::uint32_t bit(unsigned number) { return std::uint32_t{1} << number; }

inline constexpr Register CLK_REF_CTRL{0x40008030}, CLK_REF_SELECTED{0x40008038};
inline constexpr Register CLK_SYS_CTRL{0x4000803c}, CLK_SYS_SELECTED{0x40008044};
inline constexpr Register CLK_PERI_CTRL{0x40008048};
inline constexpr Register CLK_SYS_RESUS_CTRL{0x40008078};

inline constexpr Register RESETS_RESET{0x4000c000}, RESETS_RESET_DONE{0x4000c008};
inline constexpr unsigned kResetBusctrl = 1, kResetDma = 2, kResetIoBank0 = 5, kResetPadsBank0 = 8,
                          kResetPio0 = 10, kResetPio1 = 11, kResetPllSys = 12, kResetTimer = 21,
                          kResetUart0 = 22;

inline constexpr Register PSM_WDSEL{0x40010008};

constexpr Register gpio_ctrl(unsigned pin) { return Register(0x40014004 + 8 * pin); }
enum class Function : std::uint32_t { uart = 2, sio = 5, pio0 = 6 };
constexpr Register pad(unsigned pin) { return Register(0x4001c004 + 4 * pin); }
inline constexpr std::uint32_t kPadPullDown = 1U << 2, kPadPullUp = 1U << 3;

inline constexpr Register XOSC_CTRL{0x40024000}, XOSC_STATUS{0x40024004}, XOSC_STARTUP{0x4002400c};

inline constexpr Register PLL_SYS_CS{0x40028000}, PLL_SYS_PWR{0x40028004}, PLL_SYS_FBDIV_INT{0x40028008},
    PLL_SYS_PRIM{0x4002800c};

inline constexpr Register BUS_PRIORITY{0x40030000};

inline constexpr Register UARTDR{0x40034000}, UARTFR{0x40034018}, UARTIBRD{0x40034024}, UARTFBRD{0x40034028},
    UARTLCR_H{0x4003402c}, UARTCR{0x40034030}, UARTDMACR{0x40034048};
inline constexpr std::uint32_t kUartTxFull = 1U << 5;

inline constexpr Register TIMERAWL{0x40054028};

inline constexpr Register WATCHDOG_CTRL{0x40058000}, WATCHDOG_LOAD{0x40058004}, WATCHDOG_REASON{0x40058008},
    WATCHDOG_TICK{0x4005802c};

inline constexpr Register ROSC_RANDOMBIT{0x4006001c};

/// One channel of the DMA.
struct DmaChannel {
  explicit constexpr DmaChannel(unsigned index) : number(index), READ_ADDR(0x50000000 + 0x40 * index) {}
  unsigned number;
  Register READ_ADDR;
  Register WRITE_ADDR = READ_ADDR + 0x04;
  Register TRANS_COUNT = READ_ADDR + 0x08;
  Register CTRL_TRIG = READ_ADDR + 0x0c;
  Register AL1_CTRL = READ_ADDR + 0x10;
};
inline constexpr Register DMA_CHAN_ABORT{0x50000444};
inline constexpr std::uint32_t kDmaEnable = 1U << 0, kDmaHighPriority = 1U << 1, kDmaWords = 2U << 2,
                               kDmaIncrRead = 1U << 4, kDmaIncrWrite = 1U << 5, kDmaRingWrite = 1U << 10,
                               kDmaBusy = 1U << 24;
constexpr std::uint32_t dma_ring_bits(unsigned bits) { return bits << 6; }
constexpr std::uint32_t dma_chain_to(unsigned channel) { return channel << 11; }
constexpr std::uint32_t dma_paced_by(unsigned request) { return request << 15; }
inline constexpr unsigned kDreqPio0Tx0 = 0, kDreqUart0Rx = 21, kDreqNone = 0x3f;

/// One of the two PIO blocks.
struct PioBlock {
  explicit constexpr PioBlock(std::uint32_t base) : CTRL(base) {}
  Register CTRL;
  Register FSTAT = CTRL + 0x04;
  Register FDEBUG = CTRL + 0x08;
  Register FLEVEL = CTRL + 0x0c;
  Register INSTR_MEM0 = CTRL + 0x48;
  constexpr Register TXF(unsigned machine) const { return CTRL + (0x10 + 4 * machine); }
  constexpr Register RXF(unsigned machine) const { return CTRL + (0x20 + 4 * machine); }
  constexpr Register CLKDIV(unsigned machine) const { return CTRL + (0xc8 + 0x18 * machine); }
  constexpr Register EXECCTRL(unsigned machine) const { return CTRL + (0xcc + 0x18 * machine); }
  constexpr Register SHIFTCTRL(unsigned machine) const { return CTRL + (0xd0 + 0x18 * machine); }
  constexpr Register ADDR(unsigned machine) const { return CTRL + (0xd4 + 0x18 * machine); }
  constexpr Register INSTR(unsigned machine) const { return CTRL + (0xd8 + 0x18 * machine); }
  constexpr Register PINCTRL(unsigned machine) const { return CTRL + (0xdc + 0x18 * machine); }
};
inline constexpr PioBlock PIO0{0x50200000}, PIO1{0x50300000};
constexpr std::uint32_t pio_enable(unsigned machine) { return bit(machine); }
constexpr std::uint32_t pio_restart(unsigned machine) { return bit(4 + machine); }
constexpr std::uint32_t pio_clkdiv_restart(unsigned machine) { return bit(8 + machine); }
constexpr std::uint32_t pio_rx_empty(unsigned machine) { return bit(8 + machine); }   ///< of FSTAT
constexpr std::uint32_t kPioAllRxEmpty = 0xf00;                                       ///< likewise
constexpr std::uint32_t pio_tx_stall(unsigned machine) { return bit(24 + machine); }  ///< of FDEBUG
constexpr std::uint32_t pio_rx_stall(unsigned machine) { return bit(machine); }       ///< of FDEBUG

inline constexpr Register GPIO_IN{0xd0000004}, GPIO_OUT_SET{0xd0000014}, GPIO_OUT_CLR{0xd0000018},
    GPIO_OE_SET{0xd0000024};

inline constexpr Register SYST_CSR{0xe000e010}, SYST_RVR{0xe000e014}, SYST_CVR{0xe000e018};

}  // namespace strobe::sequencer
