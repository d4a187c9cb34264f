/* An ATmega328P at 16 MHz in simavr, in real time, with its serial port on a pseudo terminal.
 *
 * avr_board SKETCH.elf LINK: prints the terminal's name once LINK leads there, and runs until its
 * standard input ends. Lines there are commands:
 *   reset SECONDS  resets it; the sketch starts after that time, as with a bootloader, and bytes
 *                  received before are lost
 *   unplug         removes the terminal and LINK; the sketch keeps running
 *   plug           creates both again, and prints the terminal's name
 *   noise SHARE    damages that share of the bytes in either direction
 * A motor and its encoder are at the pins of docs/examples/board/motor_board: 7 and 8 forward and
 * backward, 9 pulse width, 2 and 3 encoder.
 */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <pty.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

enum { HZ = 16000000, SLICE = HZ / 10000 };
enum { PORTB_ = 0x25, PORTD_ = 0x2B, TCCR1A_ = 0x80, OCR1AL_ = 0x88 };

/* The motor of the simulated board in Python: see serial_link.board_parameters. */
static const double GAIN = 13.1, TIME_CONSTANT = 0.04, MAX_SPEED = 13.0, DEAD_ZONE = 0.05;
static const double COUNTS_PER_RADIAN = 1320.0 / (2.0 * M_PI);

static avr_t *avr;
static int terminal = -1, report, can_receive = 1;
static const char *link_path;
static double noise, runs_at;
static avr_irq_t *encoder[2];
static double speed, angle;
static long counts;

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec + 1e-9 * time.tv_nsec;
}

/* Change, lose or double a byte, as a bad cable does; return how many arrive. */
static int damage(uint8_t *byte) {
  if (drand48() >= noise) return 1;
  int how = lrand48() % 3;
  if (how == 0) *byte ^= 1 + lrand48() % 255;
  return how == 1 ? 2 : how == 0;
}

static void on_output(avr_irq_t *irq, uint32_t value, void *unused) {
  uint8_t byte = value;
  for (int count = damage(&byte); count > 0; count--)
    if (write(terminal, &byte, 1) != 1) return; /* no process reads: a line loses it, too */
}

static void on_flow(avr_irq_t *irq, uint32_t value, void *can) { can_receive = can != NULL; }

/* Drive the motor from the pins, and the encoder from the motor, for one time slice. */
static void turn(double seconds) {
  static const int GRAY[] = {0, 1, 3, 2};
  int width = avr->data[TCCR1A_] & 0x80 ? avr->data[OCR1AL_] : (avr->data[PORTB_] >> 1 & 1) * 255;
  int way = (avr->data[PORTD_] >> 7 & 1) - (avr->data[PORTB_] & 1);
  double share = way * width / 255.0;
  double goal = fabs(share) <= DEAD_ZONE ? 0.0 : GAIN * share;
  goal = fmax(-MAX_SPEED, fmin(MAX_SPEED, goal));
  speed += (goal - speed) * (1.0 - exp(-seconds / TIME_CONSTANT));
  angle += speed * seconds;
  long wanted = (long)floor(angle * COUNTS_PER_RADIAN);
  if (wanted == counts) return;
  counts += wanted > counts ? 1 : -1;
  int phase = GRAY[counts & 3];
  /* Otherwise a write to another pin of the port would set these to their pull-ups. */
  avr_ioport_external_t outside = {.name = 'D', .mask = 3 << 2, .value = phase << 2};
  avr_ioctl(avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &outside);
  avr_raise_irq(encoder[0], phase & 1);
  avr_raise_irq(encoder[1], phase >> 1 & 1);
}

static void connect_pins(void) {
  uint32_t flags = 0;
  avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
  flags &= ~(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  avr_irq_t *uart = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), 0);
  avr_irq_register_notify(uart + UART_IRQ_OUTPUT, on_output, NULL);
  avr_irq_register_notify(uart + UART_IRQ_OUT_XON, on_flow, &can_receive);
  avr_irq_register_notify(uart + UART_IRQ_OUT_XOFF, on_flow, NULL);
  for (int i = 0; i < 2; i++)
    encoder[i] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2 + i);
}

static void fail(const char *what) {
  fprintf(stderr, "avr_board: %s: %s\n", what, strerror(errno));
  exit(1);
}

static void open_terminal(void) {
  int other;
  char name[64];
  struct termios raw;
  if (openpty(&terminal, &other, name, NULL, NULL)) fail("terminal");
  tcgetattr(other, &raw);
  cfmakeraw(&raw);
  tcsetattr(other, TCSANOW, &raw);
  close(other);
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  if (symlink(name, link_path)) fail("link");
  dprintf(report, "%s\n", name);
}

static void close_terminal(void) {
  if (terminal < 0) return;
  unlink(link_path);
  close(terminal);
  terminal = -1;
}

/* Pass received bytes to the sketch while its port accepts them; drop them during a reset. Return
 * whether more may be waiting. */
static int feed(int is_running) {
  avr_irq_t *input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  uint8_t byte;
  while (!is_running || can_receive) {
    if (read(terminal, &byte, 1) != 1) return 0;
    for (int count = damage(&byte); count > 0 && is_running; count--) avr_raise_irq(input, byte);
  }
  return 1;
}

static void execute(const char *command) {
  if (!strncmp(command, "reset ", 6)) {
    avr_reset(avr);
    can_receive = 1;
    runs_at = now() + atof(command + 6);
  } else if (!strncmp(command, "noise ", 6)) {
    noise = atof(command + 6);
  } else if (!strcmp(command, "unplug")) {
    close_terminal();
  } else if (!strcmp(command, "plug") && terminal < 0) {
    open_terminal();
  }
}

/* The pace of the main loop suffices: a sleeping sketch must not sleep twice. */
static void on_sleep(avr_t *unused, avr_cycle_count_t cycles) {}

int main(int argc, char **argv) {
  elf_firmware_t firmware;
  memset(&firmware, 0, sizeof firmware);
  report = dup(1);
  if (!freopen("/dev/null", "w", stdout)) fail("/dev/null"); /* simavr prints there, too */
  if (argc != 3 || elf_read_firmware(argv[1], &firmware)) {
    fprintf(stderr, "usage: avr_board SKETCH.elf LINK\n");
    return 2;
  }
  avr = avr_make_mcu_by_name("atmega328p");
  avr_init(avr);
  avr->frequency = HZ;
  avr_load_firmware(avr, &firmware);
  avr->log = LOG_NONE;
  avr->sleep = on_sleep;
  link_path = argv[2];
  connect_pins();
  open_terminal();
  fcntl(0, F_SETFL, O_NONBLOCK);
  runs_at = now();
  double began = runs_at;
  avr_cycle_count_t simulated = 0, next = avr->cycle;
  for (;;) {
    char lines[256];
    ssize_t length = read(0, lines, sizeof lines - 1);
    if (length == 0) break;
    if (length > 0) {
      lines[length] = 0;
      for (char *one = strtok(lines, "\n"); one; one = strtok(NULL, "\n")) execute(one);
      next = avr->cycle;
    }
    int is_running = now() >= runs_at, is_waiting = 1;
    for (int slice = 0; slice < 10; slice++) {
      simulated += SLICE;
      if (is_waiting) is_waiting = feed(is_running);
      if (is_running) {
        next += SLICE;
        while (avr->cycle < next) {
          int state = avr_run(avr);
          if (state == cpu_Done || state == cpu_Crashed) {
            fprintf(stderr, "avr_board: the sketch has %s\n",
                    state == cpu_Done ? "ended" : "crashed");
            close_terminal();
            return 1;
          }
        }
      }
      turn((double)SLICE / HZ);
    }
    double ahead = began + (double)simulated / HZ - now();
    if (ahead < -0.1) began -= ahead; /* the machine is too slow: continue from here */
    if (ahead > 0.0) usleep((useconds_t)(1e6 * ahead));
  }
  close_terminal();
  return 0;
}
