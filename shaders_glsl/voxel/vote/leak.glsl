// A line through closed surfaces leaves as many as it enters. A column that does not leaks: somewhere along it inside and
// outside are wrong.

layout(constant_id = 0) const bool EVEN_ODD = false;

bool is_leak(int crossings) {
    return EVEN_ODD ? (crossings & 1) != 0 : crossings != 0;
}
