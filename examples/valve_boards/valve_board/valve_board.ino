// A valve board for the driver: understands the lines of ../text_board.py over its serial port.
//
// Change what is marked "of your box". The outlets open when no line `valves` has been taken for
// 250 ms; the watchdog of an AVR resets the board when this program hangs. Until `setup` has run
// the pins are inputs: a pull-down at each valve driver must keep the coils off.
//
// After a reset by its watchdog an Arduino with an old boot loader hangs in it: use Optiboot.

#if defined(__AVR__)
#include <avr/wdt.h>
#endif

// of your box: pins of outlets 1, 2, ... and of the supply's sensor
const int OUTLETS = 2;
const int INFLATE[OUTLETS] = {2, 4};
const int DEFLATE[OUTLETS] = {3, 5};
const int SENSOR[OUTLETS] = {A0, A1};
const int SUPPLY = A2;

// of your box: volts of a count, gauge pressure [Pa] = GAIN * (volts - ZERO), range of sound volts
const float VOLTS = 5.0 / 1023;
const float GAIN = 54200.0, ZERO = 0.2;            // MPX4250D: 250 kPa
const float SUPPLY_GAIN = 155500.0, SUPPLY_ZERO = 0.2;  // MPX5700D: 700 kPa
const float LOWEST = 0.05, HIGHEST = 4.9;

const unsigned long SILENCE = 250;  // without valves before the outlets open [ms]

char line[100];
unsigned int length = 0;
unsigned long heard = 0;  // when valves were taken last [ms]
long taken = 0;           // number of that line
bool watched = false;     // whether valves have been taken and the silence counts

// +1 inflate, -1 deflate, 0 closed; never both coils at once
void set_valve(int outlet, int valve) {
  if (valve <= 0) digitalWrite(INFLATE[outlet], LOW);
  if (valve >= 0) digitalWrite(DEFLATE[outlet], LOW);
  if (valve > 0) digitalWrite(INFLATE[outlet], HIGH);
  if (valve < 0) digitalWrite(DEFLATE[outlet], HIGH);
}

byte sum_of(const char *text, unsigned int count) {
  byte sum = 0;
  for (unsigned int i = 0; i < count; i++) sum ^= (byte)text[i];
  return sum;
}

// "1:+1 2:-1" into valves; false if a word is none, and nothing has moved then
bool take_valves(char *words) {
  int valves[OUTLETS] = {0};
  for (char *word = strtok(words, " "); word != NULL; word = strtok(NULL, " ")) {
    char *end;
    long outlet = strtol(word, &end, 10);
    if (*end != ':' || outlet < 1 || outlet > OUTLETS) return false;
    char *number = end + 1;
    long valve = strtol(number, &end, 10);
    if (end == number || *end != '\0' || valve < -1 || valve > 1) return false;
    valves[outlet - 1] = (int)valve;
  }
  for (int i = 0; i < OUTLETS; i++) set_valve(i, valves[i]);
  return true;
}

// appends the gauge pressure of a sensor, nan for a voltage that a sound one does not give
void append_pressure(char *text, int pin, float gain, float zero) {
  float volts = VOLTS * analogRead(pin);
  char *end = text + strlen(text);
  if (volts < LOWEST || volts > HIGHEST) {
    strcpy(end, " nan");
  } else {
    *end = ' ';
    ltoa((long)(gain * (volts - zero)), end + 1, 10);
  }
}

void answer_pressures(long question) {
  char text[20 + 12 * (OUTLETS + 2)];
  ltoa(question, text, 10);
  strcat(text, " ");
  ltoa(taken, text + strlen(text), 10);
  for (int i = 0; i < OUTLETS; i++) append_pressure(text, SENSOR[i], GAIN, ZERO);
  append_pressure(text, SUPPLY, SUPPLY_GAIN, SUPPLY_ZERO);
  strcat(text, " ");
  byte sum = sum_of(text, strlen(text));
  Serial.print(text);
  Serial.print(sum < 16 ? "*0" : "*");
  Serial.println(sum, HEX);
}

// a line without its end
void obey() {
  char *star = strchr(line, '*');
  if (star == NULL || strtol(star + 1, NULL, 16) != sum_of(line, star - line)) return;
  *star = '\0';
  char *words;
  long number = strtol(line, &words, 10);
  if (strncmp(words, " pressures", 10) == 0) {
    answer_pressures(number);
  } else if (strncmp(words, " valves ", 8) == 0 && take_valves(words + 8)) {
    taken = number;
    heard = millis();
    watched = true;
  }
}

void setup() {
  for (int i = 0; i < OUTLETS; i++) {
    digitalWrite(INFLATE[i], LOW);
    digitalWrite(DEFLATE[i], LOW);
    pinMode(INFLATE[i], OUTPUT);
    pinMode(DEFLATE[i], OUTPUT);
  }
  Serial.begin(115200);
#if defined(__AVR__)
  wdt_enable(WDTO_250MS);
#endif
}

void loop() {
#if defined(__AVR__)
  wdt_reset();
#endif
  while (Serial.available() > 0) {
    char next = Serial.read();
    if (next == '\n') {
      line[length] = '\0';
      if (length < sizeof(line) - 1) obey();
      length = 0;
    } else if (length < sizeof(line) - 1) {
      line[length++] = next;
    }
  }
  if (watched && millis() - heard > SILENCE) {
    for (int i = 0; i < OUTLETS; i++) set_valve(i, -1);
    watched = false;
  }
}
