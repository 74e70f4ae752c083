// Nothing of its own: the target that it stands for reads the headers that all tests share.
int main() { return 0; }
