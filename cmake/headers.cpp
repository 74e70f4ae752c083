// Nothing of its own: a target that compiles it reads the headers that others share.
int main() { return 0; }
