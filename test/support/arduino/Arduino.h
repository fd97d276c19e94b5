// What the sketch uses of an Arduino, on a computer: Serial is standard input and output, pins that
// change are lines "time [ms] pin level" of the standard error, analog inputs count as PINS says.
#pragma once
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

typedef unsigned char byte;
enum { LOW, HIGH, INPUT = 0, OUTPUT = 1, HEX = 16, A0 = 14, A1, A2 };
static int levels[20], modes[20];

static unsigned long millis() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1000UL + now.tv_nsec / 1000000;
}

static void pinMode(int pin, int mode) { modes[pin] = mode; }

static void digitalWrite(int pin, int level) {
  if (levels[pin] != level) fprintf(stderr, "%lu %d %d\n", millis(), pin, level);
  levels[pin] = level;
}

// "14:counts 15:counts" in the environment variable PINS; 0 for others
static int analogRead(int pin) {
  char name[8];
  snprintf(name, sizeof name, "%d:", pin);
  const char *given = getenv("PINS"), *found = given == NULL ? NULL : strstr(given, name);
  return found == NULL ? 0 : atoi(found + strlen(name));
}

static char *ltoa(long value, char *text, int) {
  sprintf(text, "%ld", value);
  return text;
}

struct SerialPort {
  void begin(long) {}
  int available() {
    pollfd port = {0, POLLIN, 0};
    return poll(&port, 1, 1) > 0;
  }
  char read() {
    char next;
    if (::read(0, &next, 1) <= 0) exit(0);
    return next;
  }
  void print(const char *text) { write(text); }
  void println(int value, int) {
    char text[8];
    snprintf(text, sizeof text, "%X\r\n", value);
    write(text);
  }
  void write(const char *text) {
    if (::write(1, text, strlen(text)) < 0) exit(1);
  }
};
static SerialPort Serial;

void setup();
void loop();
int main() {
  setup();
  while (true) loop();
}
