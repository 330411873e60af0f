"""How much submissions resemble each other, as a hint."""
